// SPDX-License-Identifier: Apache-2.0

function compiled(gl, kind, source) {
  const shader = gl.createShader(kind);
  gl.shaderSource(shader, source);
  gl.compileShader(shader);
  return shader;
}

/** A program of the graphics, and the places of its uniforms by name. */
export class Program {
  constructor(gl, vertexSource, fragmentSource) {
    this.gl = gl;
    this.program = gl.createProgram();
    const shaders = [compiled(gl, gl.VERTEX_SHADER, vertexSource), compiled(gl, gl.FRAGMENT_SHADER, fragmentSource)];
    for (const shader of shaders) gl.attachShader(this.program, shader);
    gl.linkProgram(this.program);
    this.places = new Map();
    if (gl.getProgramParameter(this.program, gl.LINK_STATUS) || gl.isContextLost()) return;
    const why = [...shaders.map((shader) => gl.getShaderInfoLog(shader)), gl.getProgramInfoLog(this.program)].join(" ");
    throw new Error(`This browser's graphics refuse the page's shader: ${why}`);
  }

  use() {
    this.gl.useProgram(this.program);
  }

  uniform(name) {
    if (!this.places.has(name)) this.places.set(name, this.gl.getUniformLocation(this.program, name));
    return this.places.get(name);
  }
}
