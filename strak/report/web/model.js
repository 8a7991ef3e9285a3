"use strict";
// Decodes the scene and puts it into WebGL buffers.

const strakDecode = (base64) => {
  const text = atob(base64);
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes.buffer;
};

// Fractions of a range, as the shader takes them: value = from + size * fraction.
const strakChannel = (gl, channel) => {
  const buffer = gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.bufferData(gl.ARRAY_BUFFER, strakDecode(channel.data), gl.STATIC_DRAW);
  return { buffer, from: channel.from, size: channel.size };
};

// Vertices of lines: point (3), direction (3); `segments` joins them two by two.
const strakLines = (gl, vertices, segments) => {
  const buffer = gl.createBuffer();
  gl.bindBuffer(gl.ARRAY_BUFFER, buffer);
  gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(vertices), gl.STATIC_DRAW);
  const indices = gl.createBuffer();
  gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, indices);
  gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, new Uint32Array(segments), gl.STATIC_DRAW);
  return { buffer, indices, count: segments.length };
};

// The vectors of a channel, three numbers each.
const strakVectors = ({ from, size, data }) =>
  Float32Array.from(new Uint16Array(strakDecode(data)), (q, i) => from[i % 3] + size[i % 3] * q / 65535);

const strakPolylines = (gl, lines) => {
  const points = strakVectors(lines.points);
  const vertices = [], segments = [];
  let first = 0;
  for (const count of lines.counts) {
    for (let i = first; i < first + count; ++i) {
      vertices.push(points[3 * i], points[3 * i + 1], points[3 * i + 2], 0, 0, 0);
      if (i > first) segments.push(i - 1, i);
    }
    first += count;
  }
  return strakLines(gl, vertices, segments);
};

// A comb has two vertices a tooth: its foot and its tip. The feet are the line itself.
const strakCombs = (gl, combs) => {
  const points = strakVectors(combs.points), directions = strakVectors(combs.directions);
  const vertices = [], teeth = [], feet = [];
  let first = 0;
  for (const count of combs.counts) {
    for (let i = first; i < first + count; ++i) {
      const foot = points.subarray(3 * i, 3 * i + 3);
      vertices.push(...foot, 0, 0, 0, ...foot, ...directions.subarray(3 * i, 3 * i + 3));
      teeth.push(2 * i, 2 * i + 1);
      if (i > first) {
        teeth.push(2 * i - 1, 2 * i + 1);
        feet.push(2 * i - 2, 2 * i);
      }
    }
    first += count;
  }
  return { teeth: strakLines(gl, vertices, teeth), feet: strakLines(gl, vertices, feet) };
};

const strakState = (gl, state, deviation) => {
  const out = { borders: strakPolylines(gl, state.borders), combs: strakCombs(gl, state.combs), mesh: null };
  if (state.mesh) {
    out.mesh = {};
    for (const name of ["points", "normals", "gaussian", "mean"]) out.mesh[name] = strakChannel(gl, state.mesh[name]);
    out.mesh.deviation = deviation;
  }
  return out;
};

// The edges between faces in one state: vertices with the place (3) and gap, angle and curvature jump (3) of the edge,
// and which of the indices belong to which edge.
const strakEdges = (gl, joins, state) => {
  const points = strakVectors(joins.lines[state].points);
  const vertices = [], segments = [], ranges = [];
  let first = 0;
  joins.lines[state].counts.forEach((count, edge) => {
    const figures = ["gap", "angle", "curvature"].map((name) => joins[name][edge][state] || 0);
    ranges.push({ faces: joins.faces[edge], first: segments.length, count: 2 * (count - 1) });
    for (let i = first; i < first + count; ++i) {
      vertices.push(points[3 * i], points[3 * i + 1], points[3 * i + 2], ...figures);
      if (i > first) segments.push(i - 1, i);
    }
    first += count;
  });
  return { ...strakLines(gl, vertices, segments), ranges };
};

// Makes the box hold a part (as it was before).
const strakExtend = (box, part) => {
  const { from, size } = part.before.mesh ? part.before.mesh.points : part.before.borders.points;
  from.forEach((value, k) => {
    box.low[k] = Math.min(box.low[k], value);
    box.high[k] = Math.max(box.high[k], value + size[k]);
  });
};

// Everything to draw: one entry an object with its parts, its box and whether it was changed.
const strakModel = (gl, scene) => scene.objects.map((object) => {
  const box = { low: [Infinity, Infinity, Infinity], high: [-Infinity, -Infinity, -Infinity] };
  const parts = object.parts.map((part) => {
    strakExtend(box, part);
    const out = { triangles: null, states: [] };
    if (part.triangles) {
      const indices = gl.createBuffer();
      gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, indices);
      const data = strakDecode(part.triangles.data);
      gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, data, gl.STATIC_DRAW);
      const bytes = part.triangles.bytes;
      out.triangles = { indices, count: data.byteLength / bytes,
                        type: bytes === 2 ? gl.UNSIGNED_SHORT : gl.UNSIGNED_INT };
    }
    const deviation = part.deviation ? strakChannel(gl, part.deviation) : null;
    const before = strakState(gl, part.before, deviation);
    out.states = [before, part.after ? strakState(gl, part.after, deviation) : before];
    out.changed = Boolean(part.after);
    return out;
  });
  return { name: object.name, parts, box, changed: parts.some((part) => part.changed) };
});
