// SPDX-License-Identifier: Apache-2.0
// A small sphere that shows where the light comes from. It is dragged, or moved with the arrow keys.
import { clamp, dot, unit } from "./vectors.js";

const LOWEST = 0.05; // sine above the picture: lower, light meets nothing
const KEY_STEP = Math.PI / 36;
const DOT = 0.035; // of the sphere's radius: where an image's light was
const LIGHT_SIDES = ["right", "upper right", "above", "upper left", "left", "lower left", "below", "lower right"];

/** A direction towards a light (right, up, towards the eye) turned so far to the right and up, never behind the picture. */
export function turned([x, y, z], right, up) {
  const azimuth = Math.atan2(x, z) + right, elevation = Math.asin(clamp(y, -1, 1)) + up;
  const level = Math.cos(clamp(elevation, -Math.PI / 2 + LOWEST, Math.PI / 2 - LOWEST));
  const most = Math.acos(Math.min(1, LOWEST / level));
  const across = clamp(azimuth, -most, most);
  const high = Math.sin(clamp(elevation, -Math.PI / 2 + LOWEST, Math.PI / 2 - LOWEST));
  return unit([level * Math.sin(across), high, level * Math.cos(across)]);
}

/** How steeply light falls on the picture. */
const degreesOff = ([, , z]) => Math.round((180 / Math.PI) * Math.asin(clamp(z, -1, 1)));

/** Where light comes from, in words. */
export function lightName([x, y, z]) {
  const above = degreesOff([x, y, z]);
  if (above > 80) return "Light from the front";
  const side = LIGHT_SIDES[Math.round(Math.atan2(y, x) / (Math.PI / 4) + 8) % 8];
  const from = side === "above" || side === "below" ? side : `the ${side}`;
  return `Light from ${from}, ${above} degrees off the picture`;
}

export class LightBall {
  /** `move(direction)`: the hand wants the light there. */
  constructor(canvas, move) {
    Object.assign(this, { canvas, move, direction: [0, 0, 1], lights: [] });
    canvas.style.touchAction = "none";
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.point(event);
    });
    canvas.addEventListener("pointermove", (event) => canvas.hasPointerCapture(event.pointerId) && this.point(event));
    canvas.addEventListener("keydown", (event) => this.key(event));
  }

  /** The light is at the place of the sphere that is pointed at. */
  point(event) {
    const box = this.canvas.getBoundingClientRect(), radius = box.width / 2;
    let x = (event.clientX - box.left) / radius - 1, y = 1 - (event.clientY - box.top) / radius;
    const most = Math.sqrt(1 - LOWEST * LOWEST), away = Math.hypot(x, y);
    if (away > most) [x, y] = [(x * most) / away, (y * most) / away];
    this.move([x, y, Math.sqrt(1 - x * x - y * y)]);
  }

  key(event) {
    const step = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    if (!step || event.ctrlKey || event.altKey || event.metaKey) return;
    this.move(turned(this.direction, KEY_STEP * step[0], KEY_STEP * step[1]));
    event.preventDefault();
  }

  /** `direction`: of the light; `lights`: those of the images. */
  show(direction, lights) {
    Object.assign(this, { direction, lights });
    const { canvas } = this, side = Math.round(canvas.clientWidth * (window.devicePixelRatio || 1));
    if (canvas.width !== side) canvas.width = canvas.height = side;
    const pen = canvas.getContext("2d"), radius = side / 2 - 1;
    const place = ([x, y]) => [side / 2 + radius * x, side / 2 - radius * y];
    const disc = ([x, y], size, colour) => {
      pen.fillStyle = colour;
      pen.beginPath();
      pen.arc(x, y, size, 0, 2 * Math.PI);
      pen.fill();
    };
    pen.clearRect(0, 0, side, side);
    const light = place(direction), shine = pen.createRadialGradient(...light, 0, ...light, 1.7 * radius);
    shine.addColorStop(0, "#fdfbf4");
    shine.addColorStop(0.35, "#b9b6ae");
    shine.addColorStop(1, "#2b2c2f");
    disc([side / 2, side / 2], radius, shine);
    for (const from of lights) if (from[2] > 0) disc(place(from), DOT * radius, "#0e7c8699");
    disc(light, 0.13 * radius, "#ffffff");
    pen.strokeStyle = "#0e7c86";
    pen.lineWidth = 0.05 * radius;
    pen.stroke();
    canvas.setAttribute("aria-valuenow", String(degreesOff(direction)));
    canvas.setAttribute("aria-valuetext", lightName(direction));
  }

  /** How many degrees the nearest light of an image is away. */
  nearestDeg() {
    const most = Math.max(...this.lights.map((from) => dot(from, this.direction)));
    return (180 / Math.PI) * Math.acos(clamp(most, -1, 1));
  }
}
