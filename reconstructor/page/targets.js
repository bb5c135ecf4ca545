// SPDX-License-Identifier: Apache-2.0
// Pictures that are not on the canvas yet.
import { Program } from "./program.js";
import { JOINING_SHADER, WHOLE_VERTEX_SHADER } from "./shaders.js";

const SAMPLES = 4;

/** Colours and depths of so many pixels; in textures that can be read, or with several samples per pixel. */
class Target {
  constructor(gl, width, height, samples = 0) {
    Object.assign(this, { gl, width, height });
    this.framebuffer = gl.createFramebuffer();
    this.bind();
    this.textures = [];
    this.buffers = [];
    for (const [place, format] of [[gl.COLOR_ATTACHMENT0, gl.RGBA8], [gl.DEPTH_ATTACHMENT, gl.DEPTH_COMPONENT24]])
      if (samples > 0) this.addBuffer(place, format, samples);
      else this.addTexture(place, format);
  }

  addTexture(place, format) {
    const gl = this.gl, texture = gl.createTexture();
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, this.width, this.height);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, place, gl.TEXTURE_2D, texture, 0);
    this.textures.push(texture);
  }

  addBuffer(place, format, samples) {
    const gl = this.gl, buffer = gl.createRenderbuffer();
    gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
    gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, format, this.width, this.height);
    gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, buffer);
    this.buffers.push(buffer);
  }

  bind() {
    this.gl.bindFramebuffer(this.gl.FRAMEBUFFER, this.framebuffer);
  }

  /** Into another framebuffer, of the canvas (null) or of the same size. */
  copyTo(framebuffer, width, height) {
    const gl = this.gl, filter = width === this.width ? gl.NEAREST : gl.LINEAR;
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, this.framebuffer);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, framebuffer);
    gl.blitFramebuffer(0, 0, this.width, this.height, 0, 0, width, height, gl.COLOR_BUFFER_BIT, filter);
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
  }

  free() {
    this.gl.deleteFramebuffer(this.framebuffer);
    this.buffers.forEach((buffer) => this.gl.deleteRenderbuffer(buffer));
    this.textures.forEach((texture) => this.gl.deleteTexture(texture));
  }
}

/** A coarse picture, which is soon there. */
export class CoarsePicture {
  constructor(gl, width, height) {
    Object.assign(this, { width, height });
    this.target = new Target(gl, width, height);
  }
  draw(draw, pixelSize) {
    this.target.bind();
    draw(this.width, this.height, { pixelSize });
  }
  show(width, height) {
    this.target.copyTo(null, width, height);
  }
  free() {
    this.target.free();
  }
}

/** A picture that is the ray painter's, with smooth outlines. */
export class FinePicture {
  constructor(gl, width, height) {
    Object.assign(this, { gl, width, height });
    this.exact = new Target(gl, width, height);
    this.several = new Target(gl, width, height, SAMPLES);
    this.smoothed = new Target(gl, width, height);
    this.outlines = new Target(gl, width, height);
    this.joining = new Program(gl, WHOLE_VERTEX_SHADER, JOINING_SHADER);
  }

  /** So many rows of it. */
  draw(draw, firstRow = 0, rows = this.height) {
    const gl = this.gl;
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(0, firstRow, this.width, rows);
    this.exact.bind();
    draw(this.width, this.height, { exact: true });
    this.several.bind();
    draw(this.width, this.height, { exact: false });
    gl.disable(gl.SCISSOR_TEST);
  }

  /** `draw`: as of `draw`. */
  show(draw) {
    this.outlines.bind();
    draw(this.width, this.height, { outlines: true });
    this.several.copyTo(this.smoothed.framebuffer, this.width, this.height);
    this.joinInto(null);
  }

  joinInto(framebuffer) {
    const gl = this.gl;
    gl.bindFramebuffer(gl.FRAMEBUFFER, framebuffer);
    gl.viewport(0, 0, this.width, this.height);
    this.joining.use();
    [["exact", this.exact.textures[0]], ["outlines", this.outlines.textures[0]], ["smoothed", this.smoothed.textures[0]]].forEach(
      ([name, texture], unit) => {
        gl.activeTexture(gl.TEXTURE0 + unit);
        gl.bindTexture(gl.TEXTURE_2D, texture);
        gl.uniform1i(this.joining.uniform(name), unit);
      });
    gl.drawArrays(gl.TRIANGLES, 0, 3);
  }

  /** RGBA, bottom row first. */
  read() {
    const gl = this.gl, { width, height } = this, pixels = new Uint8Array(4 * width * height);
    const result = new Target(gl, width, height);
    this.joinInto(result.framebuffer);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    result.free();
    return { width, height, pixels };
  }

  free() {
    for (const target of [this.exact, this.several, this.smoothed, this.outlines]) target.free();
  }
}
