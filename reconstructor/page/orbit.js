// SPDX-License-Identifier: Apache-2.0
// The camera of a person with a hand on the object: it circles round a target, one direction up, and never rolls.
import { add, clamp, cross, dot, length, scaled, subtract, unit } from "./vectors.js";

const TAN_HALF_VIEW = Math.tan(Math.PI / 9); // 40 degrees along the shorter side of the picture
const STEEPEST = 1.5; // rad: short of the pole, where azimuth means nothing
const FILLED = 0.78; // of the picture by the object at home

export class Orbit {
  /** `scene`: PageModel::scene. `vertices`: of the mesh. */
  constructor(scene, vertices) {
    this.centre = Array.from(scene.slice(0, 3));
    this.radius = Math.max(scene[3], 1e-9);
    this.reach = 0; // of what is seen beside the object, from its middle
    this.vertices = vertices;
    this.homeDirection = Array.from(scene.slice(7, 10));
    this.setUp(Array.from(scene.slice(4, 7)));
    this.target = this.centre;
    this.distance = 3 * this.radius;
    this.lookFrom(this.homeDirection);
  }

  setUp(up) {
    this.up = unit(up);
    const aside = Math.abs(this.up[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0];
    this.across = unit(subtract(aside, scaled(this.up, dot(aside, this.up))));
    this.further = cross(this.up, this.across);
  }

  lookFrom(direction) {
    const d = unit(direction);
    this.elevation = Math.asin(clamp(dot(d, this.up), -1, 1));
    this.azimuth = Math.atan2(dot(d, this.further), dot(d, this.across));
  }

  /** Looks at the target from there. */
  place(eye, target) {
    this.target = target;
    const offset = subtract(eye, target);
    this.distance = Math.max(length(offset), 1e-6 * this.radius);
    this.lookFrom(offset);
  }

  /** Upright, from where most photographs were taken, all of the object in a picture of this shape. */
  home(width, height) {
    this.target = this.centre;
    this.lookFrom(this.homeDirection);
    this.frame(width, height);
  }

  frame(width, height) {
    const shorter = Math.min(width, height);
    const tan = [(TAN_HALF_VIEW * FILLED * width) / shorter, (TAN_HALF_VIEW * FILLED * height) / shorter];
    for (let pass = 0; pass < 3; ++pass) {
      const { right, down, forward } = this.axes();
      // How far the eye must stand so that the object's left, right, upper and lower end are in the picture.
      const far = [[-Infinity, -Infinity], [-Infinity, -Infinity]];
      for (let v = 0; v < this.vertices.length; v += 3) {
        const offset = [this.vertices[v] - this.target[0], this.vertices[v + 1] - this.target[1],
                        this.vertices[v + 2] - this.target[2]];
        const depth = dot(offset, forward);
        const place = [dot(offset, right), dot(offset, down)];
        for (let axis = 0; axis < 2; ++axis) {
          far[axis][0] = Math.max(far[axis][0], -place[axis] / tan[axis] - depth);
          far[axis][1] = Math.max(far[axis][1], place[axis] / tan[axis] - depth);
        }
      }
      const shift = far.map(([low, high], axis) => ((high - low) / 2) * tan[axis]);
      this.target = add(this.target, add(scaled(right, shift[0]), scaled(down, shift[1])));
      this.distance = Math.max((far[0][0] + far[0][1]) / 2, (far[1][0] + far[1][1]) / 2, 1e-6 * this.radius);
    }
  }

  orbit(right, up) {
    this.azimuth += right;
    this.elevation = clamp(this.elevation + up, -STEEPEST, STEEPEST);
  }

  /** Moves the target across the picture, in fractions of its shorter side. */
  pan(right, up) {
    const axes = this.axes(), side = 2 * TAN_HALF_VIEW * this.distance;
    this.target = add(this.target, add(scaled(axes.right, side * right), scaled(axes.down, -side * up)));
  }

  zoom(factor) {
    this.distance = clamp(this.distance * factor, 0.05 * this.radius, 100 * this.radius);
  }

  direction() {
    const level = Math.cos(this.elevation);
    return add(scaled(this.up, Math.sin(this.elevation)),
               add(scaled(this.across, level * Math.cos(this.azimuth)), scaled(this.further, level * Math.sin(this.azimuth))));
  }

  eye() {
    return add(this.target, scaled(this.direction(), this.distance));
  }

  /** OpenCV's: right, down, forward. */
  axes() {
    const forward = scaled(this.direction(), -1), across = cross(forward, this.up);
    const right = length(across) < 1e-9 ? unit([-forward[1], forward[0], 1e-12]) : unit(across); // above: any roll
    return { right, down: cross(forward, right), forward };
  }

  /** Where a point is seen in a picture of this size, from its left upper corner. */
  project(point, width, height) {
    const { right, down, forward } = this.axes(), offset = subtract(point, this.eye());
    const pixels = Math.min(width, height) / (2 * TAN_HALF_VIEW) / dot(offset, forward);
    return [width / 2 + pixels * dot(offset, right), height / 2 + pixels * dot(offset, down)];
  }

  /** Where it stands, to come back to; `between` two of them, `part` of the way. */
  view() {
    const { target, azimuth, elevation, distance } = this;
    return { target, azimuth, elevation, distance };
  }

  between(from, to, part) {
    const mixed = (a, b) => a + (b - a) * part, turn = Math.atan2(Math.sin(to.azimuth - from.azimuth), Math.cos(to.azimuth - from.azimuth));
    this.target = from.target.map((x, i) => mixed(x, to.target[i]));
    this.azimuth = from.azimuth + turn * part;
    this.elevation = mixed(from.elevation, to.elevation);
    this.distance = from.distance * (to.distance / from.distance) ** part;
  }

  /** Clip space of a picture of this size, column by column; depths just round the object. */
  clipFromObject(width, height) {
    const { right, down, forward } = this.axes(), eye = this.eye(), shorter = Math.min(width, height);
    const sx = shorter / (TAN_HALF_VIEW * width), sy = -shorter / (TAN_HALF_VIEW * height);
    const depth = dot(subtract(this.centre, eye), forward);
    const reach = 1.01 * Math.max(this.radius, this.reach);
    const far = Math.max(depth + reach, 1e-3 * this.radius);
    const near = Math.max(depth - reach, 1e-3 * far);
    const a = (far + near) / (far - near), b = (-2 * far * near) / (far - near);
    const row = (axis, s, more = 0) => [s * axis[0], s * axis[1], s * axis[2], -s * dot(axis, eye) + more];
    const rows = [row(right, sx), row(down, sy), row(forward, a, b), row(forward, 1)];
    return Float32Array.from({ length: 16 }, (_, i) => rows[i % 4][i >> 2]);
  }

  /** A ray through the lower left corner of a picture of this size, and what leads a pixel to the right or up. */
  rays(width, height) {
    const { right, down, forward } = this.axes(), pixel = (2 * TAN_HALF_VIEW) / Math.min(width, height);
    const x = scaled(right, pixel), y = scaled(down, -pixel);
    return { ray: subtract(subtract(forward, scaled(x, width / 2)), scaled(y, height / 2)), right: x, up: y };
  }
}
