// SPDX-License-Identifier: Apache-2.0
// Where photographs were taken, as small pyramids.
import { Program } from "./program.js";
import { add, length, scaled, subtract } from "./vectors.js";

const NUMBERS = 14; // of a camera: PageModel::cameras
const LENGTH = 0.16; // of a pyramid, in radii of the object

const VERTEX = `#version 300 es
in vec3 place;
uniform mat4 clip_from_object;
void main() { gl_Position = clip_from_object * vec4(place, 1); }
`;
const FRAGMENT = `#version 300 es
precision highp float;
out vec4 color;
void main() { color = vec4(0.05, 0.49, 0.53, 1); }
`;

/** How far from the object's middle the furthest camera stands. */
export function cameraReach(cameras, centre) {
  let most = 0;
  for (let i = 0; i < cameras.length; i += NUMBERS) most = Math.max(most, length(subtract(cameras.subarray(i, i + 3), centre)));
  return most;
}

function pyramids(cameras, radius) {
  const lines = [], size = LENGTH * radius;
  for (let i = 0; i < cameras.length; i += NUMBERS) {
    const [eye, right, down, forward] = [0, 3, 6, 9].map((at) => Array.from(cameras.subarray(i + at, i + at + 3)));
    const [x, y] = [cameras[i + 12], cameras[i + 13]];
    const corners = [[-x, -y], [x, -y], [x, y], [-x, y]].map(([u, v]) =>
      add(eye, scaled(add(forward, add(scaled(right, u), scaled(down, v))), size)));
    corners.forEach((corner, k) => lines.push(...eye, ...corner, ...corner, ...corners[(k + 1) % 4]));
  }
  return Float32Array.from(lines);
}

export class CameraPyramids {
  constructor(gl, cameras, radius) {
    this.gl = gl;
    this.program = new Program(gl, VERTEX, FRAGMENT);
    const lines = pyramids(cameras, radius);
    this.vertices = lines.length / 3;
    this.array = gl.createVertexArray();
    gl.bindVertexArray(this.array);
    gl.bindBuffer(gl.ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ARRAY_BUFFER, lines, gl.STATIC_DRAW);
    const place = gl.getAttribLocation(this.program.program, "place");
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, 3, gl.FLOAT, false, 0, 0);
    gl.bindVertexArray(null);
  }

  /** Over a picture of the model. */
  draw(orbit, width, height) {
    const gl = this.gl;
    this.program.use();
    gl.uniformMatrix4fv(this.program.uniform("clip_from_object"), false, orbit.clipFromObject(width, height));
    gl.enable(gl.DEPTH_TEST);
    gl.bindVertexArray(this.array);
    gl.drawArrays(gl.LINES, 0, this.vertices);
    gl.bindVertexArray(null);
    gl.disable(gl.DEPTH_TEST);
  }
}
