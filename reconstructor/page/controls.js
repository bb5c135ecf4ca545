// SPDX-License-Identifier: Apache-2.0
// What hands do to the picture: mouse, touch and keys. Says what is to happen; the page does it.

const TURN_PER_SIDE = 3.2; // rad, for a drag along the shorter side of the picture
const KEY_TURN = Math.PI / 24, KEY_PAN = 0.05, KEY_ZOOM = 1.12, WHEEL_ZOOM = 1.0015;

export class Controls {
  /** `hands`: { orbit(right, up), drag(right, down), pan(right, up), zoom(factor), key(name) -> whether it is one of
   * the page's }; `drag` is what a dragging hand does, `orbit` what arrow keys do, both in rad. */
  constructor(canvas, hands) {
    Object.assign(this, { canvas, hands });
    this.pointers = new Map();
    this.framed = window.parent !== window;
    canvas.style.touchAction = this.framed ? "pan-y" : "none"; // a page that embeds this one goes on scrolling
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.move(event));
    for (const end of ["pointerup", "pointercancel", "lostpointercapture"])
      canvas.addEventListener(end, (event) => this.pointers.delete(event.pointerId));
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    canvas.addEventListener("blur", () => (this.entered = false));
    canvas.addEventListener("keydown", (event) => this.key(event));
  }

  side() {
    return Math.max(1, Math.min(this.canvas.clientWidth, this.canvas.clientHeight));
  }

  down(event) {
    this.canvas.focus({ preventScroll: true });
    this.entered = true;
    this.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  }

  move(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const dx = (event.clientX - before.x) / this.side(), dy = (event.clientY - before.y) / this.side();
    if (this.pointers.size === 2) {
      const [other] = [...this.pointers].filter(([id]) => id !== event.pointerId).map(([, place]) => place);
      const apart = (p) => Math.max(1, Math.hypot(p.x - other.x, p.y - other.y));
      this.hands.zoom(apart(before) / apart({ x: event.clientX, y: event.clientY }));
      this.hands.pan(-dx / 2, dy / 2);
    } else if (event.shiftKey || event.buttons & 6) {
      this.hands.pan(-dx, dy);
    } else {
      this.hands.drag(TURN_PER_SIDE * dx, TURN_PER_SIDE * dy);
    }
    this.pointers.set(event.pointerId, { x: event.clientX, y: event.clientY });
  }

  wheel(event) {
    if (this.framed && !this.entered) return;
    event.preventDefault();
    const lines = event.deltaMode === 1 ? 16 : 1;
    this.hands.zoom(WHEEL_ZOOM ** (lines * event.deltaY));
  }

  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const { hands } = this;
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (step && event.shiftKey) hands.pan(KEY_PAN * step[0], KEY_PAN * step[1]);
    else if (step) hands.orbit(KEY_TURN * step[0], KEY_TURN * step[1]);
    else if (event.key === "+" || event.key === "=") hands.zoom(1 / KEY_ZOOM);
    else if (event.key === "-") hands.zoom(KEY_ZOOM);
    else if (!hands.key(event.key.toLowerCase())) return;
    event.preventDefault();
  }
}
