"use strict";
// Draws the model with WebGL 2. Brightness, reflection and curvature are computed for every pixel from interpolated
// exact values, so lines stay sharp at any zoom.

const strakSurfaceVertex = `#version 300 es
in vec3 point, normal;
in float figure;
uniform mat3 axes;
uniform vec3 pointFrom, pointSize, normalFrom, normalSize, centre;
uniform vec2 zoom, figureRange;
uniform float depth;
out vec3 n;
out float value;
void main() {
  vec3 p = axes * (pointFrom + pointSize * point - centre);
  gl_Position = vec4(p.xy * zoom, -p.z * depth, 1.0);
  n = normalFrom + normalSize * normal;
  value = figureRange.x + figureRange.y * figure;
}`;

const strakSurfaceFragment = `#version 300 es
precision highp float;
in vec3 n;
in float value;
uniform int kind;
uniform vec3 eye, light, ground;
uniform float steps, stroke;
uniform vec2 range;
uniform vec3 colours[9];
out vec4 colour;
vec3 ramp(float t) {
  float x = clamp(t, 0.0, 1.0) * 8.0;
  int below = min(int(x), 7);
  return mix(colours[below], colours[below + 1], x - float(below));
}
void main() {
  vec3 m = normalize(n);
  float facing = abs(dot(m, eye));
  vec3 base = ground * (0.72 + 0.28 * facing);
  if (kind == 0) {                                  // isophotes: lines at n.L = (k + 1/2) step
    float f = dot(m, light) * steps;
    float width = max(fwidth(f), 1e-6);
    float line = 1.0 - smoothstep((stroke - 0.6) * width, (stroke + 0.6) * width, abs(fract(f) - 0.5));
    line = mix(line, min(1.6 * stroke * width, 0.6), smoothstep(0.35, 0.65, width));  // too dense: their average
    base = mix(mix(ground, base, 0.6), vec3(0.11, 0.15, 0.2), line);
  } else if (kind == 1) {                           // zebra: stripes of the reflected direction
    float f = dot(reflect(-eye, m), light) * steps + 0.5;
    float width = max(fwidth(f), 1e-6);
    float stripe = clamp((abs(fract(0.5 * f) - 0.5) * 2.0 - 0.5) / width + 0.5, 0.0, 1.0);
    stripe = mix(stripe, 0.5, smoothstep(0.5, 1.2, width));
    base = mix(vec3(0.13, 0.17, 0.22), vec3(0.97), stripe) * (0.85 + 0.15 * facing);
  } else if (kind == 2) {                           // colour maps
    base = ramp((value - range.x) / (range.y - range.x)) * (0.88 + 0.12 * facing);
  }
  colour = vec4(base, 1.0);
}`;

const strakLineVertex = `#version 300 es
in vec3 point, direction;
uniform mat3 axes;
uniform vec3 centre;
uniform vec2 zoom;
uniform float depth, scale, lift;
void main() {
  vec3 p = axes * (point + scale * direction - centre);
  gl_Position = vec4(p.xy * zoom, -p.z * depth - lift, 1.0);
}`;

const strakLineFragment = `#version 300 es
precision mediump float;
uniform vec4 ink;
out vec4 colour;
void main() { colour = ink; }`;

// Edges coloured by one of their three figures; drawn several times a little beside themselves, they look wide.
const strakEdgeVertex = `#version 300 es
in vec3 point, figures;
uniform mat3 axes;
uniform vec3 centre, which;
uniform vec2 zoom, shift;
uniform float depth, lift;
out float value;
void main() {
  vec3 p = axes * (point - centre);
  gl_Position = vec4(p.xy * zoom + shift, -p.z * depth - lift, 1.0);
  value = dot(which, figures);
}`;

const strakEdgeColours = [[26, 152, 80], [254, 204, 92], [227, 26, 28], [84, 0, 48]];

const strakEdgeFragment = `#version 300 es
precision highp float;
in float value;
uniform float most;
uniform vec3 colours[4];
out vec4 colour;
void main() {
  float x = clamp(value / most, 0.0, 1.0) * 3.0;
  int below = min(int(x), 2);
  colour = vec4(mix(colours[below], colours[below + 1], x - float(below)), 1.0);
}`;

const strakProgram = (gl, vertex, fragment) => {
  const program = gl.createProgram();
  for (const [type, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(program));
  const places = {};
  for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS); ++i) {
    const name = gl.getActiveUniform(program, i).name.replace("[0]", "");
    places[name] = gl.getUniformLocation(program, name);
  }
  for (let i = 0; i < gl.getProgramParameter(program, gl.ACTIVE_ATTRIBUTES); ++i) {
    const name = gl.getActiveAttrib(program, i).name;
    places[name] = gl.getAttribLocation(program, name);
  }
  return { program, places };
};

class StrakPainter {
  constructor(gl, colours) {
    this.gl = gl;
    this.surface = strakProgram(gl, strakSurfaceVertex, strakSurfaceFragment);
    this.line = strakProgram(gl, strakLineVertex, strakLineFragment);
    this.edge = strakProgram(gl, strakEdgeVertex, strakEdgeFragment);
    this.edgeColours = new Float32Array(strakEdgeColours.flat().map((c) => c / 255));
    this.colours = new Float32Array(colours.flat().map((c) => c / 255));
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    gl.clearColor(1, 1, 1, 1);
  }

  clear() {
    this.gl.disable(this.gl.SCISSOR_TEST);
    this.gl.clear(this.gl.COLOR_BUFFER_BIT | this.gl.DEPTH_BUFFER_BIT);
  }

  // Draws objects in one state (0 before, 1 after) into a rectangle of the canvas, cut to `clip`.
  draw(objects, state, rectangle, clip, look) {
    const gl = this.gl;
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(...clip);
    gl.viewport(...rectangle);
    const extent = Math.min(rectangle[2], rectangle[3]) / 2;
    this.pixel = [2 / rectangle[2], 2 / rectangle[3]];
    this.camera = {
      axes: [0, 1, 2].flatMap((k) => [look.right[k], look.up[k], look.eye[k]]), centre: look.centre,
      zoom: [look.zoom * extent / (rectangle[2] / 2), look.zoom * extent / (rectangle[3] / 2)], depth: look.depth,
    };
    for (const object of objects)
      for (const part of object.parts) this.drawSurface(part, part.states[state], look);
    for (const object of objects)
      for (const part of object.parts) this.drawLines(part, part.states[state], look);
  }

  // `edges` of one state; all of them, or those of one face.
  drawEdges(edges, face, look) {
    const gl = this.gl, places = this.edge.places;
    this.useCamera(this.edge);
    gl.uniform3fv(places.which, ["gap", "angle", "curvature"].map((name) => (name === look.edges ? 1 : 0)));
    gl.uniform1f(places.most, look.edgeMost);
    gl.uniform3fv(places.colours, this.edgeColours);
    gl.uniform1f(places.lift, 8e-4);
    gl.bindBuffer(gl.ARRAY_BUFFER, edges.buffer);
    for (const [k, name] of ["point", "figures"].entries()) {
      gl.enableVertexAttribArray(places[name]);
      gl.vertexAttribPointer(places[name], 3, gl.FLOAT, false, 24, 12 * k);
    }
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, edges.indices);
    const ranges = face < 0 ? [{ first: 0, count: edges.count }] : edges.ranges.filter((r) => r.faces.includes(face));
    for (let turn = 0; turn < 9; ++turn) {
      const radius = turn ? look.edgeWidth : 0, angle = turn * Math.PI / 4;
      gl.uniform2f(places.shift, radius * Math.cos(angle) * this.pixel[0], radius * Math.sin(angle) * this.pixel[1]);
      for (const { first, count } of ranges) gl.drawElements(gl.LINES, count, gl.UNSIGNED_INT, 4 * first);
    }
  }

  useCamera({ program, places }) {
    const gl = this.gl, camera = this.camera;
    gl.useProgram(program);
    gl.uniformMatrix3fv(places.axes, false, camera.axes);
    gl.uniform3fv(places.centre, camera.centre);
    gl.uniform2fv(places.zoom, camera.zoom);
    gl.uniform1f(places.depth, camera.depth);
  }

  drawSurface(part, state, look) {
    if (!part.triangles) return;
    const gl = this.gl, places = this.surface.places, mesh = state.mesh;
    this.useCamera(this.surface);
    const figure = mesh[look.kind];
    const isMap = look.kind === "gaussian" || look.kind === "mean" || (look.kind === "deviation" && figure);
    gl.uniform1i(places.kind, look.kind === "isophotes" ? 0 : look.kind === "zebra" ? 1 : isMap ? 2 : 3);
    gl.uniform3fv(places.eye, look.eye);
    gl.uniform3fv(places.light, look.light);
    gl.uniform3fv(places.ground, look.compare && !part.changed ? [0.9, 0.9, 0.9] : [0.95, 0.96, 0.975]);
    gl.uniform1f(places.steps, look.steps);
    gl.uniform1f(places.stroke, look.stroke);
    gl.uniform2fv(places.range, look.range);
    gl.uniform3fv(places.colours, this.colours);
    this.attribute(places.point, mesh.points.buffer, 3);
    gl.uniform3fv(places.pointFrom, mesh.points.from);
    gl.uniform3fv(places.pointSize, mesh.points.size);
    this.attribute(places.normal, mesh.normals.buffer, 3);
    gl.uniform3fv(places.normalFrom, mesh.normals.from);
    gl.uniform3fv(places.normalSize, mesh.normals.size);
    const shown = isMap ? figure : mesh.mean;
    this.attribute(places.figure, shown.buffer, 1);
    gl.uniform2f(places.figureRange, shown.from, shown.size);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, part.triangles.indices);
    gl.drawElements(gl.TRIANGLES, part.triangles.count, part.triangles.type, 0);
  }

  attribute(place, buffer, numbers) {
    const gl = this.gl;
    gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
    gl.enableVertexAttribArray(place);
    gl.vertexAttribPointer(place, numbers, gl.UNSIGNED_SHORT, true, 0, 0);
  }

  drawLines(part, state, look) {
    this.useCamera(this.line);
    this.strokes(state.borders, [0.11, 0.15, 0.2, 1], 0, 4e-4);
    if (look.isolines) this.strokes(state.combs.feet, [0.35, 0.4, 0.45, 0.8], 0, 3e-4);
    if (look.combs) this.strokes(state.combs.teeth, [0.69, 0.23, 0.18, 0.75], look.combScale, 3e-4);
  }

  strokes(lines, ink, scale, lift) {
    const gl = this.gl, places = this.line.places;
    gl.uniform4fv(places.ink, ink);
    gl.uniform1f(places.scale, scale);
    gl.uniform1f(places.lift, lift);
    gl.bindBuffer(gl.ARRAY_BUFFER, lines.buffer);
    for (const [k, name] of ["point", "direction"].entries()) {
      gl.enableVertexAttribArray(places[name]);
      gl.vertexAttribPointer(places[name], 3, gl.FLOAT, false, 24, 12 * k);
    }
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, lines.indices);
    gl.drawElements(gl.LINES, lines.count, gl.UNSIGNED_INT, 0);
  }
}
