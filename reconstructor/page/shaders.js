// SPDX-License-Identifier: Apache-2.0
// The window's shading in WebGL 2, where textures of two dimensions take the place of buffers.

// Compiled in two ways. Where graphics round corners to sixteenths of a pixel, another triangle than the ray through the
// middle of the pixel meets is sometimes shaded. With EXACT triangles are drawn a little larger, and what the ray does not
// meet is left out: the picture is the ray painter's. Its outlines are as ragged as pixels are.

const HEAD = (exact) => `#version 300 es
${exact ? "#define EXACT" : ""}
precision highp float;
precision highp int;
precision highp sampler2D;
precision highp usampler2D;
precision highp sampler2DArray;
`;

/** Vertices come out of textures: vertex 3 t + c is corner c of triangle t. */
export const vertexShader = (exact) => HEAD(exact) + `
uniform sampler2D vertices;
uniform usampler2D places;  // three texels per triangle: PageModel::places
uniform mat4 clip_from_object;
flat out uvec4 columns, terms;
flat out int side;
#ifdef EXACT
uniform vec3 eye;
uniform vec2 half_size;          // of the picture, pixels
flat out vec3 plane_a, plane_b, plane_c;  // normals of the planes through the eye and the edge opposite a corner
#else
centroid out vec3 beta;     // never outside the triangle, also where several samples make a pixel
out vec3 position;
#endif

vec3 vertex(uint i) { return texelFetch(vertices, ivec2(i & 4095u, i >> 12), 0).xyz; }

uvec4 place(int i) { return texelFetch(places, ivec2(i & 4095, i >> 12), 0); }

#ifdef EXACT
vec4 clip(vec3 place) { return clip_from_object * vec4(place, 1); }

// A corner, an eighth of a pixel further from both its edges.
vec4 grown(vec4 p, vec4 q, vec4 r) {
  if (min(p.w, min(q.w, r.w)) <= 0.0) return p;
  vec2 at = half_size * p.xy / p.w, to_q = half_size * q.xy / q.w - at, to_r = half_size * r.xy / r.w - at;
  to_q /= max(length(to_q), 1e-6);
  to_r /= max(length(to_r), 1e-6);
  vec2 inwards = to_q + to_r;
  float sine = max(0.5 * length(to_q - to_r), 0.125);  // of half the angle: no corner goes further than a pixel
  return p - vec4(0.125 / sine * inwards / max(length(inwards), 1e-6) / half_size * p.w, 0, 0);
}
#endif

void main() {
  int triangle = gl_VertexID / 3, corner = gl_VertexID - 3 * triangle;
  uvec4 shape = place(3 * triangle);
  columns = place(3 * triangle + 1);
  terms = place(3 * triangle + 2);
  side = int(shape.w);
#ifdef EXACT
  vec3 a = vertex(shape.x), b = vertex(shape.y), c = vertex(shape.z);
  vec4 p = clip(corner == 0 ? a : corner == 1 ? b : c), q = clip(corner == 0 ? b : corner == 1 ? c : a),
       r = clip(corner == 0 ? c : corner == 1 ? a : b);
  gl_Position = grown(p, q, r);
  a -= eye;
  b -= eye;
  c -= eye;
  plane_a = cross(b, c - b);
  plane_b = cross(c, a - c);
  plane_c = cross(a, b - a);
#else
  beta = vec3(corner == 0, corner == 1, corner == 2);
  position = vertex(shape[corner]);
  gl_Position = clip_from_object * vec4(position, 1);
#endif
}
`;

export const fragmentShader = (exact) => HEAD(exact) + `
uniform sampler2DArray means, basis;
uniform sampler2D coefficients;
uniform int means_bits, basis_bits;  // of a texel's number: those above say its layer
uniform int stride;          // of coefficients; 0: none are there, only the means are drawn
uniform int shading;         // 0: what a camera would see, 1: the mesh in grey
uniform bool mark_guesses;
uniform vec3 eye;
uniform float exposure, brightest, pixel_size;
flat in uvec4 columns, terms;
flat in int side;
#ifdef EXACT
uniform vec3 ray, ray_right, ray_up;  // through the lower left corner of the picture, and by a pixel
flat in vec3 plane_a, plane_b, plane_c;
#else
centroid in vec3 beta;
in vec3 position;
#endif
out vec4 color;

const vec3 UNKNOWN = vec3(0.20, 0.21, 0.24);
const float INSIDE = 0.35;

vec4 texel(sampler2DArray map, int layer_bits, int i) {
  return texelFetch(map, ivec3(i & 4095, (i & ((1 << layer_bits) - 1)) >> 12, i >> layer_bits), 0);
}
float coefficient(int i) { return texelFetch(coefficients, ivec2(i & 4095, i >> 12), 0).x; }

int lattice_index(int n, int i, int j) { return i * n - i * (i - 1) / 2 + j; }

// Three lattice points and their weights: lattice_stencil of the CPU.
void lattice_stencil(int n, float u, float v, out ivec3 index, out vec3 weight) {
  float cu = clamp(u, 0.0, 1.0) * float(n - 1);
  float cv = clamp(v, 0.0, 1.0 - clamp(u, 0.0, 1.0)) * float(n - 1);
  int i = min(int(cu), n - 2);
  int j = min(int(cv), n - 2 - i);
  float a = cu - float(i), b = cv - float(j);
  if (a + b <= 1.0 || i + j + 2 > n - 1) {
    float s = max(1.0, a + b);
    index = ivec3(lattice_index(n, i, j), lattice_index(n, i + 1, j), lattice_index(n, i, j + 1));
    weight = vec3(max(0.0, 1.0 - a - b), a / s, b / s);
  } else {
    index = ivec3(lattice_index(n, i + 1, j + 1), lattice_index(n, i, j + 1), lattice_index(n, i + 1, j));
    weight = vec3(a + b - 1.0, 1.0 - a, 1.0 - b);
  }
}

// Grey by the angle to the eye: shape where there is no colour.
float facing(vec3 normal, vec3 direction) { return abs(dot(normalize(normal), normalize(direction))); }

float stripe() { return step(6.0, mod(pixel_size * (gl_FragCoord.x + gl_FragCoord.y), 12.0)); }

// The exposure scales light, not encoded values.
vec3 exposed(vec3 encoded) {
  if (exposure == 1.0) return encoded;
  vec3 low = encoded / 12.92, high = pow(max(encoded + 0.055, 0.0) / 1.055, vec3(2.4));
  vec3 light = exposure * mix(low, high, vec3(greaterThan(encoded, vec3(0.04045))));
  return mix(12.92 * light, 1.055 * pow(max(light, 0.0), vec3(1.0 / 2.4)) - 0.055,
             vec3(greaterThan(light, vec3(0.0031308))));
}

// What is a guess, because no photograph showed it, is striped.
vec3 marked(vec3 encoded, bool guess) {
  return guess && mark_guesses ? mix(encoded, UNKNOWN, 0.45 * stripe()) : encoded;
}

// Sum over the three corners and all their terms, sRGB-encoded.
vec3 light_field(vec3 beta, out bool guess) {
  ivec3 index;
  vec3 weight;
  lattice_stencil(side, beta.y, beta.z, index, weight);
  ivec3 sample_at = int(columns.w) + index;
  vec4 a = texel(means, means_bits, sample_at.x), b = texel(means, means_bits, sample_at.y), c = texel(means, means_bits, sample_at.z);
  guess = !((weight.x > 0.25 && a.a > 0.25) || (weight.y > 0.25 && b.a > 0.25) || (weight.z > 0.25 && c.a > 0.25));
  vec3 mean = weight.x * a.rgb + weight.y * b.rgb + weight.z * c.rgb;
  vec3 sum = uintBitsToFloat(terms.z) + uintBitsToFloat(terms.w) * mean;
  if (stride == 0) return sum;
  int count = int(terms.y);
  ivec3 at = int(terms.x) + index * count, h = stride * ivec3(columns.xyz);
  for (int r = 0; r < count; ++r) {
    float amount = dot(beta, vec3(coefficient(h.x + r), coefficient(h.y + r), coefficient(h.z + r)));
    vec3 here = weight.x * texel(basis, basis_bits, at.x + r).rgb + weight.y * texel(basis, basis_bits, at.y + r).rgb +
                weight.z * texel(basis, basis_bits, at.z + r).rgb;
    sum += amount * (here - 128.0 / 255.0);
  }
  return min(sum, vec3(brightest));
}

void main() {
#ifdef EXACT
  vec3 direction = ray + gl_FragCoord.x * ray_right + gl_FragCoord.y * ray_up;
  vec3 beta = vec3(dot(direction, plane_a), dot(direction, plane_b), dot(direction, plane_c));
  float sum = beta.x + beta.y + beta.z;
  beta /= sum;
  if (!(min(beta.x, min(beta.y, beta.z)) > -1e-6)) discard;
  bool front = sum < 0.0;
  float grey = facing(plane_a + plane_b + plane_c, direction);
#else
  bool front = gl_FrontFacing;
  float grey = facing(cross(dFdx(position), dFdy(position)), eye - position);
#endif
  color = vec4(0, 0, 0, 1);
  if (shading == 1) {
    color.rgb = vec3(0.72) * (0.25 + 0.75 * grey);
  } else if (!front) {
    color.rgb = marked(vec3(INSIDE), true);  // which no photograph shows
  } else if (terms.y == 0xffffffffu) {
    color.rgb = UNKNOWN * (0.55 + 0.45 * grey) + 0.035 * stripe();
  } else {
    bool guess;
    vec3 encoded = light_field(beta, guess);
    color.rgb = marked(exposed(encoded), guess);
  }
}
`;

/** All of the picture. */
export const WHOLE_VERTEX_SHADER = HEAD(false) + `
void main() { gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1); }
`;

/** Lines between vertices of the mesh. */
export const OUTLINE_VERTEX_SHADER = HEAD(false) + `
uniform sampler2D vertices;
uniform mat4 clip_from_object;
void main() {
  gl_Position = clip_from_object * vec4(texelFetch(vertices, ivec2(gl_VertexID & 4095, gl_VertexID >> 12), 0).xyz, 1);
}
`;
export const OUTLINE_SHADER = HEAD(false) + `
out vec4 mark;
void main() { mark = vec4(1); }
`;

// Outlines, and the pixels beside them, from a picture with several samples per pixel, all else from the exact one.
export const JOINING_SHADER = HEAD(false) + `
uniform sampler2D exact, outlines, smoothed;
out vec4 color;

void main() {
  ivec2 here = ivec2(gl_FragCoord.xy), last = textureSize(outlines, 0) - 1;
  vec4 one = texelFetch(exact, here, 0), several = texelFetch(smoothed, here, 0);
  float outline = one.a - several.a;
  for (int y = -1; y <= 1; ++y)
    for (int x = -1; x <= 1; ++x)
      outline = max(outline, texelFetch(outlines, clamp(here + ivec2(x, y), ivec2(0), last), 0).x);
  color = outline > 0.0 ? several : one;
}
`;
