// SPDX-License-Identifier: Apache-2.0
// Brings pictures to the canvas as fast as a person moves them and as fine as the screen shows them: coarse at once, and
// fine in pieces, between which the page looks after its mouse.
import { Pacer } from "./pacer.js";
import { CoarsePicture, FinePicture } from "./targets.js";

const PIECE_MS = 30; // for which a new movement may wait
const FIRST_PIECES = 8; // of a picture while it is not known what one takes
const LEAST_ROWS = 16;
const REST_MS = 90; // without a movement, then the fine picture is begun

export class Painter {
  /** `draw(width, height, { exact, pixelSize, outlines })` draws into the framebuffer that is bound. */
  constructor(gl, canvas, draw) {
    Object.assign(this, { gl, canvas, draw });
    this.pacer = new Pacer();
    this.coarse = this.fine = null;
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

  /** The last fine picture: its pixels as RGBA, bottom row first. */
  read() {
    return this.fine.read();
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

  /** The picture of the kind, remade where it has another size. */
  sized(Kind, old, width, height) {
    if (old && old.width === width && old.height === height) return old;
    if (old) old.free();
    return new Kind(this.gl, width, height);
  }

  move() {
    const { canvas, pacer } = this, frame = pacer.frame(), begun = performance.now();
    this.changed = false;
    this.frames += 1;
    if (frame.smooth) {
      this.fine = this.sized(FinePicture, this.fine, canvas.width, canvas.height);
      this.fine.draw(this.draw);
      this.fine.show(this.draw);
    } else {
      const part = (size) => Math.max(1, Math.ceil(size / frame.pixel));
      this.coarse = this.sized(CoarsePicture, this.coarse, part(canvas.width), part(canvas.height));
      this.coarse.draw(this.draw, frame.pixel);
      this.coarse.show(canvas.width, canvas.height);
    }
    this.whenDrawn(() => {
      pacer.moved(performance.now() - begun);
      if (this.changed) return this.next();
      if (frame.smooth) this.fineIsThere();
      else this.rest = setTimeout(() => this.next(), REST_MS);
    });
  }

  refine() {
    const { canvas, pacer, generation } = this, begun = performance.now();
    const pieces = pacer.fineMs > 0 ? Math.ceil(pacer.fineMs / PIECE_MS) : FIRST_PIECES;
    const rows = Math.max(LEAST_ROWS, Math.ceil(canvas.height / pieces));
    this.fine = this.sized(FinePicture, this.fine, canvas.width, canvas.height);
    this.fine.draw(this.draw, this.rowsDone, rows);
    this.whenDrawn(() => {
      if (generation !== this.generation) return this.next();
      this.fineMs = (this.rowsDone > 0 ? this.fineMs : 0) + performance.now() - begun;
      this.rowsDone += rows;
      if (this.rowsDone < canvas.height) return this.next();
      pacer.rested(this.fineMs);
      this.fine.show(this.draw);
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
