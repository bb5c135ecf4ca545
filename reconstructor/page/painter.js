// SPDX-License-Identifier: Apache-2.0
// Brings pictures to the canvas as fast as a person moves them and as fine as the screen shows them: coarse at once, and
// fine in pieces, between which the page looks after its mouse.
import { Pacer } from "./pacer.js";

const PIECE_MS = 30; // for which a new movement may wait
const FIRST_PIECES = 8; // of a picture while it is not known what one takes
const LEAST_ROWS = 16;
const REST_MS = 90; // without a movement, then the fine picture is begun
const SAMPLES = 0;

/** A picture that is not shown, of so many samples per pixel. */
class Target {
  constructor(gl, width, height, samples) {
    Object.assign(this, { gl, width, height });
    this.framebuffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.framebuffer);
    this.buffers = [[gl.COLOR_ATTACHMENT0, gl.RGBA8], [gl.DEPTH_ATTACHMENT, gl.DEPTH_COMPONENT24]].map(([place, format]) => {
      const buffer = gl.createRenderbuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
      gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, format, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, place, gl.RENDERBUFFER, buffer);
      return buffer;
    });
  }

  bind() {
    this.gl.bindFramebuffer(this.gl.FRAMEBUFFER, this.framebuffer);
  }

  /** Onto the canvas. */
  show(width, height) {
    const gl = this.gl;
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, this.framebuffer);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, null);
    const filter = width === this.width ? gl.NEAREST : gl.LINEAR;
    gl.blitFramebuffer(0, 0, this.width, this.height, 0, 0, width, height, gl.COLOR_BUFFER_BIT, filter);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  free() {
    this.gl.deleteFramebuffer(this.framebuffer);
    this.buffers.forEach((buffer) => this.gl.deleteRenderbuffer(buffer));
  }
}

export class Painter {
  /** `draw(width, height, pixelSize)` draws into the framebuffer that is bound. */
  constructor(gl, canvas, draw) {
    Object.assign(this, { gl, canvas, draw });
    this.pacer = new Pacer();
    this.targets = {};
    this.changed = false; // since the frame that is on its way
    this.busy = false;
    this.rowsDone = 0;
    this.generation = 0; // of what is to be seen
    this.frames = 0; // of movements
    this.waiting = []; // for a fine picture
  }

  /** Something else is to be seen: soon, and then finely. */
  change() {
    this.changed = true;
    this.generation += 1;
    this.rowsDone = 0;
    this.next();
  }

  /** Resolves when the fine picture of what is to be seen now is on the canvas, before it is handed to the screen. */
  finished() {
    return new Promise((resolve) => this.waiting.push(resolve));
  }

  /** RGBA, bottom row first, of the last fine picture. */
  read() {
    const { gl, canvas } = this, pixels = new Uint8Array(4 * canvas.width * canvas.height);
    this.targets.fine.bind();
    gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return { width: canvas.width, height: canvas.height, pixels };
  }

  next() {
    if (this.busy || this.gl.isContextLost()) return;
    this.busy = true;
    if (this.changed) {
      clearTimeout(this.rest);
      requestAnimationFrame(() => this.move());
    } else if (this.rowsDone < this.canvas.height) {
      requestAnimationFrame(() => this.refine());
    } else {
      this.busy = false;
    }
  }

  target(name, width, height, samples) {
    const old = this.targets[name];
    if (old && old.width === width && old.height === height) return old;
    if (old) old.free();
    return (this.targets[name] = new Target(this.gl, width, height, samples));
  }

  move() {
    const { canvas, pacer } = this, frame = pacer.frame(), begun = performance.now();
    this.changed = false;
    this.frames += 1;
    const part = (size) => Math.max(1, Math.ceil(size / frame.pixel));
    const width = part(canvas.width), height = part(canvas.height);
    const target = frame.smooth ? this.target("fine", width, height, SAMPLES) : this.target("coarse", width, height, 0);
    target.bind();
    this.draw(width, height, frame.pixel);
    target.show(canvas.width, canvas.height);
    this.whenDrawn(() => {
      pacer.moved(performance.now() - begun);
      if (this.changed) return this.next();
      if (!frame.smooth) this.rest = setTimeout(() => this.next(), REST_MS);
      else this.fineIsThere();
    });
  }

  refine() {
    const { canvas, pacer, gl } = this, begun = performance.now();
    const pieces = pacer.fineMs > 0 ? Math.ceil(pacer.fineMs / PIECE_MS) : FIRST_PIECES;
    const rows = Math.max(LEAST_ROWS, Math.ceil(canvas.height / pieces));
    const target = this.target("fine", canvas.width, canvas.height, SAMPLES);
    target.bind();
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(0, this.rowsDone, canvas.width, rows);
    this.draw(canvas.width, canvas.height, 1);
    gl.disable(gl.SCISSOR_TEST);
    const generation = this.generation;
    this.whenDrawn(() => {
      if (generation !== this.generation) return this.next();
      this.fineMs = (this.rowsDone > 0 ? this.fineMs : 0) + performance.now() - begun;
      this.rowsDone += rows;
      if (this.rowsDone < canvas.height) return this.next();
      pacer.rested(this.fineMs);
      target.show(canvas.width, canvas.height);
      this.fineIsThere();
    });
  }

  fineIsThere() {
    this.rowsDone = this.canvas.height;
    for (const resolve of this.waiting.splice(0)) resolve();
  }

  /** The graphics are busy until then: nothing else is asked of them. */
  whenDrawn(then) {
    const { gl } = this, fence = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0);
    gl.flush();
    const look = () => {
      if (!gl.isContextLost() && fence && gl.clientWaitSync(fence, 0, 0) === gl.TIMEOUT_EXPIRED) return setTimeout(look, 2);
      if (fence) gl.deleteSync(fence);
      this.busy = false;
      return then();
    };
    setTimeout(look, 0);
  }
}
