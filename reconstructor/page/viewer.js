// SPDX-License-Identifier: Apache-2.0
// Draws a model with WebGL 2: maps in textures of `ROW` texels a row.
import { Program } from "./program.js";
import { fragmentShader, OUTLINE_SHADER, OUTLINE_VERTEX_SHADER, vertexShader } from "./shaders.js";
import { subtract } from "./vectors.js";

const ROW = 4096;
const LARGE_LAYER_BITS = 24, SMALL_LAYER_BITS = 21; // a texture that one layer does not hold, or that grows, has small ones
const UNITS = { vertices: 0, places: 1, means: 2, basis: 3, coefficients: 4 };
const LAYERS = 128; // of depth, in which triangles are sorted

export class Viewer {
  constructor(gl) {
    this.gl = gl;
    this.programs = [false, true].map((exact) => {
      const program = new Program(gl, vertexShader(exact), fragmentShader(exact));
      program.use();
      for (const [name, unit] of Object.entries(UNITS)) gl.uniform1i(program.uniform(name), unit);
      return program;
    });
    this.outlining = new Program(gl, OUTLINE_VERTEX_SHADER, OUTLINE_SHADER);
    this.outline = gl.createBuffer();
    this.order = gl.createBuffer();
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.order);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    this.textures = {};
    this.triangles = 0;
    this.stride = 0;
    this.exposure = 1;
    this.brightest = Infinity;
    this.coloured = false;
    this.setBasisRoom(0);
    this.table("coefficients", new Float32Array(1), gl.R32F, gl.RED, gl.FLOAT, 1);
    this.meansBits = this.layered("means", 0);
  }

  bound(name, kind) {
    const gl = this.gl;
    gl.activeTexture(gl.TEXTURE0 + UNITS[name]);
    if (!this.textures[name]) this.textures[name] = gl.createTexture();
    gl.bindTexture(kind, this.textures[name]);
    gl.texParameteri(kind, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(kind, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
  }

  /** A texture of so many numbers per texel, as many rows as it takes. */
  table(name, numbers, internal, format, type, perTexel) {
    const gl = this.gl, rows = Math.max(1, Math.ceil(numbers.length / perTexel / ROW));
    const padded = new numbers.constructor(rows * ROW * perTexel);
    padded.set(numbers);
    this.bound(name, gl.TEXTURE_2D);
    gl.texImage2D(gl.TEXTURE_2D, 0, internal, ROW, rows, 0, format, type, padded);
  }

  /** Room for so many texels of 8 bits in layers. Of the old texture, as many layers are kept. */
  layered(name, texels, grows = false, kept = 0) {
    const gl = this.gl, rows = Math.max(1, Math.ceil(texels / ROW)), old = this.textures[name];
    const bits = rows * ROW <= 1 << LARGE_LAYER_BITS && !grows ? LARGE_LAYER_BITS : SMALL_LAYER_BITS;
    const height = grows ? 1 << (bits - 12) : Math.min(rows, 1 << (bits - 12));
    delete this.textures[name];
    this.bound(name, gl.TEXTURE_2D_ARRAY);
    gl.texStorage3D(gl.TEXTURE_2D_ARRAY, 1, gl.RGBA8, ROW, height, Math.ceil(rows / height));
    if (kept > 0) this.copyLayers(old, kept, height);
    if (old) gl.deleteTexture(old);
    return bits;
  }

  /** From another texture into the one that is bound. */
  copyLayers(from, count, height) {
    const gl = this.gl, framebuffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, framebuffer);
    for (let layer = 0; layer < count; ++layer) {
      gl.framebufferTextureLayer(gl.READ_FRAMEBUFFER, gl.COLOR_ATTACHMENT0, from, 0, layer);
      gl.copyTexSubImage3D(gl.TEXTURE_2D_ARRAY, 0, 0, 0, layer, 0, 0, ROW, height);
    }
    gl.deleteFramebuffer(framebuffer);
  }

  /** Texels of means or terms, from a place on. */
  write(name, first, texels) {
    const gl = this.gl, bits = name === "means" ? this.meansBits : this.basisBits, height = 1 << (bits - 12);
    this.bound(name, gl.TEXTURE_2D_ARRAY);
    for (let done = 0, all = texels.length / 4; done < all;) {
      const column = (first + done) % ROW, row = Math.floor((first + done) / ROW), left = all - done;
      const width = Math.min(ROW - column, left);
      const rows = width < ROW ? 1 : Math.min(Math.floor(left / ROW), height - (row % height));
      gl.texSubImage3D(gl.TEXTURE_2D_ARRAY, 0, column, row % height, Math.floor(row / height), width, rows, 1, gl.RGBA,
                       gl.UNSIGNED_BYTE, texels, 4 * done);
      done += width * rows;
    }
  }

  setMesh({ vertices, triangles, edges, brightest }) {
    const gl = this.gl;
    this.vertices = vertices;
    this.edges = edges;
    this.corners = triangles;
    this.triangles = triangles.length / 3;
    this.sortedFor = "";
    this.brightest = brightest;
    this.table("vertices", vertices, gl.RGB32F, gl.RGB, gl.FLOAT, 3);
    const places = new Uint32Array(4 * triangles.length);
    for (let t = 0; t < this.triangles; ++t) places.set(triangles.subarray(3 * t, 3 * t + 3), 12 * t);
    this.setPlaces(places);
  }

  setPlaces(places) {
    this.table("places", places, this.gl.RGBA32UI, this.gl.RGBA_INTEGER, this.gl.UNSIGNED_INT, 4);
  }

  setMeans(places, means) {
    this.setPlaces(places);
    this.meansBits = this.layered("means", means.length / 4);
    this.write("means", 0, means);
    this.coloured = true;
  }

  setBasisRoom(texels) {
    this.basisBits = this.layered("basis", texels);
    this.basisRows = 0;
  }

  /** Of a model that grows: for all means, and for so many texels of terms. */
  setRooms(means, terms) {
    this.meansBits = this.layered("means", means);
    this.basisBits = this.layered("basis", terms, true);
    this.basisLayers = Math.ceil(terms / (1 << this.basisBits));
  }

  /** Room for so many texels of terms, or more; what is there stays. Returns for how many. */
  growBasis(texels) {
    const layers = Math.ceil(texels / (1 << this.basisBits));
    this.layered("basis", texels, true, this.basisLayers);
    this.basisLayers = layers;
    return layers * (1 << this.basisBits);
  }

  addBasis(texels) {
    this.write("basis", ROW * this.basisRows, texels);
    this.basisRows += texels.length / (4 * ROW);
  }

  setCoefficients(coefficients, stride, exposure) {
    const gl = this.gl;
    this.stride = stride;
    this.exposure = exposure;
    if (stride === 0) return;
    if (this.coefficientCount !== coefficients.length) this.table("coefficients", coefficients, gl.R32F, gl.RED, gl.FLOAT, 1);
    else this.replaceCoefficients(coefficients);
    this.coefficientCount = coefficients.length;
  }

  replaceCoefficients(coefficients) {
    const gl = this.gl, rows = Math.floor(coefficients.length / ROW), rest = coefficients.length - rows * ROW;
    this.bound("coefficients", gl.TEXTURE_2D);
    if (rows > 0) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, ROW, rows, gl.RED, gl.FLOAT, coefficients);
    if (rest > 0) gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, rows, rest, 1, gl.RED, gl.FLOAT, coefficients, rows * ROW);
  }

  /** Triangles that face the eye from the nearest to the farthest, then the others, so that little is shaded in vain. */
  sort(eye, centre, radius) {
    const { vertices, corners, gl } = this;
    this.facing = new Uint8Array(this.triangles);
    const bucket = new Uint16Array(this.triangles), first = new Uint32Array(2 * LAYERS + 1);
    const nearest = Math.hypot(...subtract(eye, centre)) - radius, perMetre = LAYERS / (2 * radius);
    for (let t = 0; t < this.triangles; ++t) {
      const a = 3 * corners[3 * t], b = 3 * corners[3 * t + 1], c = 3 * corners[3 * t + 2];
      const x = eye[0] - vertices[a], y = eye[1] - vertices[a + 1], z = eye[2] - vertices[a + 2];
      const bx = vertices[b] - vertices[a], by = vertices[b + 1] - vertices[a + 1], bz = vertices[b + 2] - vertices[a + 2];
      const cx = vertices[c] - vertices[a], cy = vertices[c + 1] - vertices[a + 1], cz = vertices[c + 2] - vertices[a + 2];
      const faces = x * (by * cz - bz * cy) + y * (bz * cx - bx * cz) + z * (bx * cy - by * cx) > 0;
      this.facing[t] = faces ? 1 : 0;
      const depth = Math.min(LAYERS - 1, Math.max(0, perMetre * (Math.sqrt(x * x + y * y + z * z) - nearest)));
      bucket[t] = Math.floor(depth) + (faces ? 0 : LAYERS);
      ++first[bucket[t] + 1];
    }
    for (let i = 1; i < first.length; ++i) first[i] += first[i - 1];
    const order = new Uint32Array(3 * this.triangles);
    for (let t = 0; t < this.triangles; ++t) {
      const at = 3 * first[bucket[t]]++;
      order[at] = 3 * t;
      order[at + 1] = 3 * t + 1;
      order[at + 2] = 3 * t + 2;
    }
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, order, gl.STREAM_DRAW);
  }

  /** Into the framebuffer that is bound, of this size. `pixelSize`: of its pixels in those of the picture. */
  draw(orbit, width, height, { exact = false, pixelSize = 1, markGuesses = true } = {}) {
    const gl = this.gl, eye = orbit.eye(), program = this.programs[exact ? 1 : 0];
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    if (this.triangles === 0) return;
    program.use();
    for (const [name, unit] of Object.entries(UNITS)) {
      gl.activeTexture(gl.TEXTURE0 + unit);
      gl.bindTexture(name === "means" || name === "basis" ? gl.TEXTURE_2D_ARRAY : gl.TEXTURE_2D, this.textures[name]);
    }
    gl.enable(gl.DEPTH_TEST);
    gl.uniformMatrix4fv(program.uniform("clip_from_object"), false, orbit.clipFromObject(width, height));
    gl.uniform3fv(program.uniform("eye"), eye);
    gl.uniform1i(program.uniform("means_bits"), this.meansBits);
    gl.uniform1i(program.uniform("basis_bits"), this.basisBits);
    gl.uniform1i(program.uniform("stride"), this.stride);
    gl.uniform1i(program.uniform("shading"), this.coloured ? 0 : 1);
    gl.uniform1i(program.uniform("mark_guesses"), markGuesses ? 1 : 0);
    gl.uniform1f(program.uniform("exposure"), this.exposure);
    gl.uniform1f(program.uniform("brightest"), this.brightest);
    gl.uniform1f(program.uniform("pixel_size"), pixelSize);
    if (exact) {
      gl.uniform2f(program.uniform("half_size"), width / 2, height / 2);
      const { ray, right, up } = orbit.rays(width, height);
      gl.uniform3fv(program.uniform("ray"), ray);
      gl.uniform3fv(program.uniform("ray_right"), right);
      gl.uniform3fv(program.uniform("ray_up"), up);
    }
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.order);
    if (this.sortedFor !== eye.join()) this.sort(eye, orbit.centre, orbit.radius);
    this.sortedFor = eye.join();
    gl.drawElements(gl.TRIANGLES, 3 * this.triangles, gl.UNSIGNED_INT, 0);
    gl.disable(gl.DEPTH_TEST);
  }

  /** Marks where the surface ends, or one side of it faces the eye of the last `draw` and the other does not. */
  drawOutlines(orbit, width, height) {
    const { gl, edges, facing } = this, lines = new Uint32Array(edges.length / 2);
    let count = 0;
    for (let e = 0; e < edges.length; e += 4) {
      if (edges[e + 2] !== edges[e + 3] && facing[edges[e + 2]] === facing[edges[e + 3]]) continue;
      lines[count++] = edges[e];
      lines[count++] = edges[e + 1];
    }
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT);
    this.outlining.use();
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.textures.vertices);
    gl.uniform1i(this.outlining.uniform("vertices"), 0);
    gl.uniformMatrix4fv(this.outlining.uniform("clip_from_object"), false, orbit.clipFromObject(width, height));
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.outline);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, lines.subarray(0, count), gl.STREAM_DRAW);
    gl.drawElements(gl.LINES, count, gl.UNSIGNED_INT, 0);
  }
}
