"use strict";
// The controls of the interactive view.

class StrakViewer {
  constructor(gl, scene) {
    this.gl = gl;
    this.scene = scene;
    this.canvas = gl.canvas;
    this.painter = new StrakPainter(gl, scene.colours);
    this.objects = strakModel(gl, scene);
    this.selected = -1;  // -1: the whole part
    const has = (test) => this.objects.some((object) => object.parts.some(test));
    this.hasSurfaces = has((part) => part.triangles);
    const lineKind = scene.kind === "isolines" || scene.kind === "combs" || !this.hasSurfaces;
    this.kind = lineKind ? "shaded" : scene.kind;
    this.layout = "sides";
    const input = (id) => document.getElementById(id);
    this.inputs = Object.fromEntries(
      ["azimuth", "elevation", "density", "range", "comb", "swipe", "combs", "isolines", "object", "layout", "reset", "edges",
       "edgeRange"]
        .map((id) => [id, input(id)]));
    this.inputs.combs.checked = scene.kind === "combs" || !this.hasSurfaces;
    this.inputs.isolines.checked = scene.kind === "isolines";
    this.inputs.density.value = scene.lines;
    this.setLight(scene.light);
    this.edges = scene.joins ? [0, 1].map((state) => strakEdges(gl, scene.joins, state)) : null;
    this.addObjects();
    this.addListeners();
    input("viewer").hidden = false;
    input("noViewer").hidden = true;
    if (!scene.compare) for (const id of ["layoutField", "tagLeft", "tagRight"]) input(id).hidden = true;
    if (!this.hasSurfaces) for (const id of ["kinds", "isolinesField"]) input(id).hidden = true;
    input("edgesField").hidden = !this.edges;
    document.querySelector('[data-kind="deviation"]').hidden = !scene.compare;
    this.reset();
    new ResizeObserver(() => this.later()).observe(this.canvas);
  }

  // The light relative to the first view: angle around its upright axis, height above its horizon.
  setLight(light) {
    const { right, up, view } = this.scene;
    const along = (axis) => axis.reduce((sum, value, k) => sum + value * light[k], 0);
    this.inputs.azimuth.value = Math.atan2(along(right), along(view)) * 180 / Math.PI;
    this.inputs.elevation.value = Math.asin(Math.max(-1, Math.min(1, along(up)))) * 180 / Math.PI;
  }

  light() {
    const { right, up, view } = this.scene;
    const around = this.inputs.azimuth.value * Math.PI / 180, height = this.inputs.elevation.value * Math.PI / 180;
    return [0, 1, 2].map((k) => Math.cos(height) * (Math.sin(around) * right[k] + Math.cos(around) * view[k]) +
                                Math.sin(height) * up[k]);
  }

  addObjects() {
    const select = this.inputs.object;
    select.add(new Option("the whole part", "-1"));
    this.objects.forEach((object, i) => {
      if (object.parts.length) select.add(new Option(object.name + (object.changed ? "" : this.scene.compare ? " (left alone)" : ""), String(i)));
    });
    document.getElementById("objectField").hidden = select.options.length < 3;
    for (const row of document.querySelectorAll("tr[data-object]")) {
      if (!this.objects[row.dataset.object]?.parts.length) continue;
      row.addEventListener("click", () => {
        this.select(Number(row.dataset.object));
        document.getElementById("viewer").scrollIntoView({ behavior: "smooth", block: "nearest" });
      });
    }
  }

  addListeners() {
    for (const button of document.querySelectorAll("[data-kind]"))
      button.addEventListener("click", () => { this.kind = button.dataset.kind; this.later(); });
    for (const id of ["azimuth", "elevation", "density", "range", "comb", "swipe", "combs", "isolines", "edges", "edgeRange"])
      this.inputs[id].addEventListener("input", () => this.later());
    this.inputs.object.addEventListener("change", () => this.select(Number(this.inputs.object.value)));
    this.inputs.layout.addEventListener("change", () => { this.layout = this.inputs.layout.value; this.fit(); });
    this.inputs.reset.addEventListener("click", () => this.reset());

    const canvas = this.canvas, pointers = new Map();
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      pointers.set(event.pointerId, [event.offsetX, event.offsetY]);
      const bar = this.layout === "swipe" && this.scene.compare ? this.inputs.swipe.value * canvas.clientWidth : -99;
      this.dragsBar = Math.abs(event.offsetX - bar) < 9;
    });
    for (const name of ["pointerup", "pointercancel"])
      canvas.addEventListener(name, (event) => pointers.delete(event.pointerId));
    canvas.addEventListener("pointermove", (event) => {
      const before = pointers.get(event.pointerId);
      if (!before) return;
      const now = [event.offsetX, event.offsetY], dx = now[0] - before[0], dy = now[1] - before[1];
      if (pointers.size === 2) {
        const other = [...pointers].find(([id]) => id !== event.pointerId)[1];
        const distance = (p) => Math.max(Math.hypot(p[0] - other[0], p[1] - other[1]), 1);
        this.view.zoom *= distance(now) / distance(before);
        this.move(dx / 2, dy / 2);
      } else if (this.dragsBar) {
        this.inputs.swipe.value = now[0] / canvas.clientWidth;
      } else if (event.shiftKey || event.buttons & 6) {
        this.move(dx, dy);
      } else {
        this.turn(dx * 0.008, dy * 0.008);
      }
      pointers.set(event.pointerId, now);
      this.later();
    });
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.view.zoom *= Math.exp(-event.deltaY * (event.deltaMode ? 0.05 : 0.0015));
      this.later();
    }, { passive: false });
    canvas.addEventListener("keydown", (event) => {
      const keys = { ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, -0.1], ArrowDown: [0, 0.1] };
      if (keys[event.key]) this.turn(...keys[event.key]);
      else if (event.key === "+" || event.key === "-") this.view.zoom *= event.key === "+" ? 1.15 : 1 / 1.15;
      else return;
      event.preventDefault();
      this.later();
    });
  }

  // Turns the camera around its own upright and horizontal axis.
  turn(across, down) {
    const v = this.view;
    const rotate = (a, b, angle) => {
      const c = Math.cos(angle), s = Math.sin(angle);
      return [a.map((x, k) => c * x + s * b[k]), b.map((x, k) => c * x - s * a[k])];
    };
    [v.right, v.eye] = rotate(v.right, v.eye, across);
    [v.up, v.eye] = rotate(v.up, v.eye, -down);
  }

  move(dx, dy) {
    const v = this.view, [, , width, height] = this.rectangles()[0];
    const unit = this.ratio() / (v.zoom * Math.min(width, height) / 2);
    v.centre = v.centre.map((x, k) => x - (dx * v.right[k] - dy * v.up[k]) * unit);
  }

  shown() { return this.selected < 0 ? this.objects : [this.objects[this.selected]]; }

  select(index) {
    this.selected = index;
    this.inputs.object.value = String(index);
    for (const row of document.querySelectorAll("tr[data-object]"))
      row.setAttribute("aria-selected", String(Number(row.dataset.object) === index));
    this.fit();
  }

  reset() {
    const { right, up, view } = this.scene;
    this.view = { right: [...right], up: [...up], eye: [...view], centre: [0, 0, 0], zoom: 1 };
    this.fit();
  }

  fit() {
    const low = [0, 1, 2].map((k) => Math.min(...this.shown().map((o) => o.box.low[k])));
    const high = [0, 1, 2].map((k) => Math.max(...this.shown().map((o) => o.box.high[k])));
    if (!low.every(Number.isFinite)) return;
    const v = this.view, half = low.map((x, k) => (high[k] - x) / 2);
    v.centre = low.map((x, k) => (x + high[k]) / 2);
    const reach = (axis) => Math.max(axis.reduce((sum, x, k) => sum + Math.abs(x) * half[k], 0), 1e-9 * this.scene.size);
    this.resize();
    const [, , width, height] = this.rectangles()[0], extent = Math.min(width, height) / 2;
    v.zoom = 0.94 * Math.min(width / 2 / reach(v.right), height / 2 / reach(v.up)) / extent;
    this.later();
  }

  // Pixels of the canvas per pixel of the page: at least two, for fine lines.
  ratio() { return Math.min(Math.max(window.devicePixelRatio || 1, 2), 3); }

  resize() {
    const canvas = this.canvas, ratio = this.ratio();
    const width = Math.max(Math.round(canvas.clientWidth * ratio), 2);
    const height = Math.max(Math.round(canvas.clientHeight * ratio), 2);
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  }

  rectangles() {
    const { width, height } = this.canvas, half = Math.floor(width / 2);
    if (!this.scene.compare || this.layout === "swipe") return [[0, 0, width, height]];
    return [[0, 0, half, height], [width - half, 0, half, height]];
  }

  later() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => { this.waiting = false; this.draw(); });
  }

  // The figure that gets the darkest colour: the largest of both states, unless the slider says less.
  edgeMost() {
    const figures = this.edges && this.scene.joins[this.inputs.edges.value];
    if (!figures) return 1;
    return Math.max(...figures.flat().map((x) => x || 0), Number.MIN_VALUE) * 10 ** this.inputs.edgeRange.value;
  }

  paint(objects, state, place, clip, look) {
    this.painter.draw(objects, state, place, clip, look);
    if (look.edges) this.painter.drawEdges(this.edges[state], this.selected, look);
  }

  look() {
    const { scene, kind } = this, ranges = scene.ranges;
    const light = ranges[kind === "zebra" ? "zebra" : "isophotes"];
    const map = ranges[kind] || [0, 1], middle = (map[0] + map[1]) / 2;
    const spread = (map[1] - map[0]) / 2 * 10 ** this.inputs.range.value;
    return {
      ...this.view, kind, stroke: 0.35 * this.ratio(), compare: scene.compare, light: this.light(), depth: 0.5 / scene.size,
      steps: this.inputs.density.value / (light[1] - light[0]), range: [middle - spread, middle + spread],
      edges: this.inputs.edges.value, edgeWidth: 1.1 * this.ratio(), edgeMost: this.edgeMost(),
      combs: this.inputs.combs.checked, isolines: this.inputs.isolines.checked,
      combScale: ranges.combs > 0 ? 0.08 * scene.size / ranges.combs * 10 ** this.inputs.comb.value : 0,
    };
  }

  draw() {
    this.resize();
    const look = this.look(), { width, height } = this.canvas, objects = this.shown();
    const swipe = this.scene.compare && this.layout === "swipe";
    const places = this.rectangles(), bar = Math.round(width * (swipe ? this.inputs.swipe.value : 0.5));
    this.painter.clear();
    if (swipe) {
      this.paint(objects, 0, places[0], [0, 0, bar, height], look);
      this.paint(objects, 1, places[0], [bar, 0, width - bar, height], look);
    } else {
      places.forEach((place, state) => this.paint(objects, state, place, place, look));
    }
    this.update(look, swipe, bar / width);
  }

  updateEdgeLegend(look) {
    document.getElementById("edgeLegend").hidden = !look.edges;
    if (!look.edges) return;
    const { unit } = this.scene;
    const names = { gap: `Gap${unit && ` (${unit})`}`, angle: "Angle (degrees)",
                    curvature: `Curvature jump${unit && ` (1/${unit})`}` };
    document.getElementById("edgeName").textContent = names[look.edges];
    document.getElementById("edgeRamp").style.background =
      `linear-gradient(to right, ${strakEdgeColours.map((c) => `rgb(${c.join(",")})`).join(",")})`;
    document.getElementById("edgeMiddle").textContent = (look.edgeMost / 2).toPrecision(3);
    document.getElementById("edgeHigh").textContent = look.edgeMost.toPrecision(3);
  }

  // Buttons, sliders and legend follow what is shown.
  update(look, swipe, bar) {
    for (const button of document.querySelectorAll("[data-kind]"))
      button.setAttribute("aria-pressed", String(button.dataset.kind === this.kind));
    const lines = this.kind === "isophotes" || this.kind === "zebra";
    const map = ["gaussian", "mean", "deviation"].includes(this.kind);
    const needed = { light: lines, density: lines, colour: map, combs: look.combs, swipe, edges: look.edges };
    for (const label of document.querySelectorAll(".sliders label")) label.hidden = !needed[label.dataset.for];
    const divider = document.getElementById("divider");
    divider.hidden = !this.scene.compare;
    divider.style.left = `${100 * bar}%`;
    this.updateEdgeLegend(look);
    document.getElementById("legend").hidden = !map;
    if (!map) return;
    const { unit, colours } = this.scene;
    const names = { gaussian: `Gaussian curvature${unit && ` (1/${unit}\u00B2)`}`,
                    mean: `Mean curvature${unit && ` (1/${unit})`}`,
                    deviation: `Moved along the normal${unit && ` (${unit})`}` };
    const number = (x) => (Math.abs(x) < 1e-3 * look.range[1] - 1e-3 * look.range[0] ? "0" : x.toPrecision(3).replace("-", "\u2212"));
    document.getElementById("legendName").textContent = names[this.kind];
    document.getElementById("ramp").style.background =
      `linear-gradient(to right, ${colours.map((c) => `rgb(${c.join(",")})`).join(",")})`;
    document.getElementById("legendLow").textContent = number(look.range[0]);
    document.getElementById("legendMiddle").textContent = number((look.range[0] + look.range[1]) / 2);
    document.getElementById("legendHigh").textContent = number(look.range[1]);
  }
}

{
  const canvas = document.getElementById("canvas");
  const gl = canvas && canvas.getContext("webgl2", { antialias: true, alpha: false });
  document.documentElement.dataset.viewer = gl ? "ready" : "unavailable";
  if (gl) {
    canvas.addEventListener("webglcontextlost", (event) => event.preventDefault());
    canvas.addEventListener("webglcontextrestored", () => location.reload());
    window.strakViewer = new StrakViewer(gl, JSON.parse(document.getElementById("scene").textContent));
  }
}
