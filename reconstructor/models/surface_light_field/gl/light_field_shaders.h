// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace sheen {

/// Vertices come out of buffers: vertex 3 t + c is corner c of triangle t.
inline constexpr const char* kSurfaceVertexShader = R"glsl(#version 330 core
uniform samplerBuffer positions;
uniform usamplerBuffer corners;
uniform mat4 clip_from_object;
flat out int triangle;
centroid out vec3 beta;     // barycentric weights; never outside the triangle, also where several samples make a pixel
out vec3 position_object;

void main() {
  uint vertex = texelFetch(corners, gl_VertexID).x;
  int corner = gl_VertexID % 3;
  triangle = gl_VertexID / 3;
  beta = vec3(corner == 0, corner == 1, corner == 2);
  position_object = texelFetch(positions, int(vertex)).xyz;
  gl_Position = clip_from_object * vec4(position_object, 1);
}
)glsl";

/// What the fragment shader is made for. Drawing in software costs what the shader says, also on ways not taken.
struct SurfaceShaderVariant {
  int buffers = 1;  ///< of basis texels
  bool operator==(const SurfaceShaderVariant&) const = default;
};

inline constexpr const char* kSurfaceFragmentShader = R"glsl(
uniform usamplerBuffer corners, resolutions, slots;
uniform samplerBuffer coefficients, quality;
uniform samplerBuffer basis0, basis1, basis2, basis3;
uniform int coefficient_stride;
uniform int shading;               // SurfaceShading
uniform vec3 eye;
uniform float exposure;            // of this eye: ExposureField
uniform float pixel_size;          // DrawArea
uniform float inside_grey;         // of the backs of triangles, sRGB-encoded
uniform vec3 need_colors[3];       // from known to unknown
uniform vec3 reason_colors[6];     // by QualityReason
uniform vec3 state_colors[2];      // by SampleState: unseen, imputed
uniform vec3 demand_colors[4];     // from little to much
uniform vec3 evidence_colors[3];   // by ShapeEvidence
flat in int triangle;
centroid in vec3 beta;
in vec3 position_object;
out vec4 color;

vec4 fetch_basis(uint buffer, int texel) {
#if BUFFERS > 1
  if (buffer == 1u) return texelFetch(basis1, texel);
#endif
#if BUFFERS > 2
  if (buffer == 2u) return texelFetch(basis2, texel);
#endif
#if BUFFERS > 3
  if (buffer == 3u) return texelFetch(basis3, texel);
#endif
  return texelFetch(basis0, texel);
}

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
float facing() {
  vec3 normal = normalize(cross(dFdx(position_object), dFdy(position_object)));
  return abs(dot(normal, normalize(eye - position_object)));
}

float stripe() { return step(6.0, mod(pixel_size * (gl_FragCoord.x + gl_FragCoord.y), 12.0)); }

vec3 unknown_color() { return vec3(0.20, 0.21, 0.24) * (0.55 + 0.45 * facing()) + 0.035 * stripe(); }

// The exposure scales light, not encoded values (srgb_decode, srgb_encode).
vec3 exposed(vec3 encoded) {
  if (exposure == 1.0) return encoded;
  vec3 low = encoded / 12.92, high = pow(max(encoded + 0.055, 0.0) / 1.055, vec3(2.4));
  vec3 light = exposure * mix(low, high, vec3(greaterThan(encoded, vec3(0.04045))));
  return mix(12.92 * light, 1.055 * pow(max(light, 0.0), vec3(1.0 / 2.4)) - 0.055,
             vec3(greaterThan(light, vec3(0.0031308))));
}

vec3 need_color(float need) {
  return need < 0.5 ? mix(need_colors[0], need_colors[1], 2.0 * need)
                    : mix(need_colors[1], need_colors[2], 2.0 * need - 1.0);
}

// What is a guess, because no image showed it, is striped; where the states are asked for, they tint the surface.
vec3 marked(vec3 encoded, int state) {
  if (shading == 3 && state < 2) return mix(encoded, state_colors[state], state == 1 ? 0.5 : 0.35 + 0.45 * stripe());
  return state > 0 ? encoded : mix(encoded, vec3(0.20, 0.21, 0.24), 0.45 * stripe());
}

// Sum over the three corners and all their terms, sRGB-encoded (000 sec. 4.1). The state is the best of the samples that
// weigh in, as the CPU's ViewShader has it. False where nothing is known.
bool light_field(out vec3 encoded, out int state) {
  ivec3 index;
  vec3 weight;
  lattice_stencil(int(texelFetch(resolutions, triangle).x), beta.y, beta.z, index, weight);
  vec3 sum = vec3(0);
  state = 0;
  // The corners differ only in their coefficients: these are blended, and the maps are read once.
  uvec4 corner = texelFetch(corners, 3 * triangle);  // vertex, patch, first sample, column
  uvec2 slot = texelFetch(slots, int(corner.y)).xy;
  int rank = int(slot.y & 0xffffu);
  if (rank == 0) return false;
  uint buffer = slot.y >> 16;
  ivec3 texel = int(slot.x) + (int(corner.z) + index) * rank;
  ivec3 h = coefficient_stride * ivec3(corner.w, texelFetch(corners, 3 * triangle + 1).w,
                                       texelFetch(corners, 3 * triangle + 2).w);
  for (int r = 0; r < rank; ++r) {
    vec4 a = fetch_basis(buffer, texel.x + r), b = fetch_basis(buffer, texel.y + r), c = fetch_basis(buffer, texel.z + r);
    if (r == 0) {
      if (weight.x > 0.25) state = int(a.a + 0.5);
      if (weight.y > 0.25) state = max(state, int(b.a + 0.5));
      if (weight.z > 0.25) state = max(state, int(c.a + 0.5));
    }
    float coefficient = dot(beta, vec3(texelFetch(coefficients, h.x + r).x, texelFetch(coefficients, h.y + r).x,
                                       texelFetch(coefficients, h.z + r).x));
    sum += coefficient * (weight.x * a.rgb + weight.y * b.rgb + weight.z * c.rgb);
  }
  encoded = sum;
  return true;
}

vec3 appearance() {
  if (!gl_FrontFacing) return marked(vec3(inside_grey), 0);  // which no image shows, as the ray painter has it
  vec3 encoded;
  int state;
  if (!light_field(encoded, state)) return shading == 3 ? marked(unknown_color(), 0) : unknown_color();
  return marked(exposed(encoded), state);
}

void main() {
  if (shading == 4) {
    color = vec4(vec3(0.72) * (0.25 + 0.75 * facing()), 1);  // plain_grey of the headless painter
    return;
  }
  if (shading == 0 || shading == 3) {
    color = vec4(appearance(), 1);
    return;
  }
  if (shading == 8) {
    float level = texelFetch(quality, triangle).x;
    vec3 hue = level < 1.0 ? mix(evidence_colors[0], evidence_colors[1], level)
                           : mix(evidence_colors[1], evidence_colors[2], level - 1.0);
    color = vec4(hue * (0.35 + 0.65 * facing()), 1);
    return;
  }
  if (shading > 4) {
    float level = texelFetch(quality, triangle).x, place = 3.0 * level;
    int below = clamp(int(place), 0, 2);
    vec3 hue = mix(demand_colors[below], demand_colors[below + 1], place - float(below));
    color = vec4(level < 0.0 ? unknown_color() : hue * (0.8 + 0.2 * facing()), 1);
    return;
  }
  vec2 need = gl_FrontFacing ? texelFetch(quality, triangle).xy : vec2(1, 1);  // the back: not at all, unseen
  float shape = 0.65 + 0.35 * facing();  // a hint of it: the hue means need
  vec3 hue = shading == 1 ? need_color(need.x) : mix(need_colors[0], reason_colors[int(need.y + 0.5)], need.x);
  color = vec4(hue * shape, 1);
}
)glsl";

inline std::string surface_fragment_shader(const SurfaceShaderVariant& variant) {
  return "#version 330 core\n#define BUFFERS " + std::to_string(variant.buffers) + kSurfaceFragmentShader;
}

}  // namespace sheen
