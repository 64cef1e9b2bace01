// SPDX-License-Identifier: BSD-3-Clause
// Where: the way in three dimensions, with reference, points, and how uncertain the place is. X forward, Y left, Z up, m.
import * as THREE from "./vendor/three.module.min.js";
import { verdictColours } from "./colours.js";
import { lengthText, sigmaOfPlace } from "./record.js";

const cell = 0.3;            // m: of two points so near, one is kept
const mostPoints = 60000;    // then the oldest go
const mostWay = 120000;      // vertices: then the way is kept with half as many

const softwarePeriod = 100;  // ms between pictures where the processor draws them

// Whether there is a graphics card, or the processor has to do it.
function isSoftware() {
  const gl = document.createElement("canvas").getContext("webgl2");
  const info = gl?.getExtension("WEBGL_debug_renderer_info");
  const name = info ? gl.getParameter(info.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}

// A buffer that grows, of three numbers and a colour a vertex.
class Growing {
  constructor(object) {
    this.object = object;
    object.frustumCulled = false;
    this.room = 1024;
    this.count = 0;
    this.from = Infinity; this.to = 0;  // vertices that have changed
    this.places = new Float32Array(3 * this.room);
    this.colours = new Float32Array(3 * this.room);
    this.attach();
  }
  attach() {
    this.object.geometry.dispose();
    this.object.geometry = new THREE.BufferGeometry();
    this.object.geometry.setAttribute("position", new THREE.BufferAttribute(this.places, 3));
    this.object.geometry.setAttribute("color", new THREE.BufferAttribute(this.colours, 3));
    this.touched(0, this.count);
  }
  add(p, colour) {
    if (this.count === this.room) {
      this.room *= 2;
      const places = new Float32Array(3 * this.room), colours = new Float32Array(3 * this.room);
      places.set(this.places); colours.set(this.colours);
      this.places = places; this.colours = colours;
      this.attach();
    }
    this.put(this.count++, p, colour);
  }
  put(at, p, colour) {
    this.places.set(p, 3 * at);
    this.colours.set([colour.r, colour.g, colour.b], 3 * at);
    this.touched(at, at + 1);
  }
  // What has changed goes to the graphics card, no more.
  flush() {
    const g = this.object.geometry;
    g.setDrawRange(0, this.count);
    if (this.from >= this.to) return;
    for (const a of [g.attributes.position, g.attributes.color]) {
      a.clearUpdateRanges();
      a.addUpdateRange(3 * this.from, 3 * (this.to - this.from));
      a.needsUpdate = true;
    }
    this.from = Infinity;
    this.to = 0;
  }
  clear() { this.count = 0; this.touched(0, 0); }
  touched(from, to) { this.from = Math.min(this.from, from); this.to = Math.max(this.to, to); }

  // Of pieces a-b and b-c becomes a-c; breaks stay, and so does the colour that is not `usual`.
  halve(usual) {
    const from = this.places.slice(0, 3 * this.count), tint = this.colours.slice(0, 3 * this.count), n = this.count;
    const at = (list, v) => list.subarray(3 * v, 3 * v + 3), same = (a, b) => a[0] === b[0] && a[1] === b[1] && a[2] === b[2];
    const known = new Float32Array([usual.r, usual.g, usual.b]);
    this.count = 0;
    for (let v = 0; v < n; ) {
      const joined = v + 3 < n && same(at(from, v + 1), at(from, v + 2)), last = joined ? v + 3 : v + 1;
      const c = joined && same(at(tint, v), known) ? at(tint, v + 2) : at(tint, v);
      for (const p of [v, last]) { this.places.set(at(from, p), 3 * this.count); this.colours.set(c, 3 * this.count++); }
      v = last + 1;
    }
    this.touched(0, this.count);
  }
}

// L of a symmetric positive matrix: takes the unit sphere to the 1-sigma ellipsoid.
export function cholesky([xx, yy, zz, xy, xz, yz]) {
  const a = Math.sqrt(Math.max(xx, 1e-12)), b = xy / a, d = xz / a;
  const c = Math.sqrt(Math.max(yy - b * b, 1e-12)), e = (yz - b * d) / c;
  return [[a, 0, 0], [b, c, 0], [d, e, Math.sqrt(Math.max(zz - d * d - e * e, 1e-12))]];
}

export class ScenePanel {
  constructor(element, legend) {
    this.element = element;
    this.legend = legend;
    this.target = new THREE.Vector3();
    this.azimuth = Math.PI; this.elevation = 0.5; this.distance = 12;  // from behind
    this.follow = true;
    this.cells = new Map();  // of a point's place: its number
    this.software = isSoftware();
    this.renderer = new THREE.WebGLRenderer({ antialias: !this.software });
    this.labels = document.createElement("canvas");
    this.labels.style.pointerEvents = "none";
    element.append(this.renderer.domElement, this.labels);
    this.scene = new THREE.Scene();
    this.scene.background = new THREE.Color(0x0b1016);
    this.camera = new THREE.PerspectiveCamera(45, 1, 0.05, 20000);
    this.camera.up.set(0, 0, 1);
    const line = (opacity) => new THREE.LineSegments(new THREE.BufferGeometry(), new THREE.LineBasicMaterial({ vertexColors: true, transparent: opacity < 1, opacity }));
    this.path = new Growing(line(1));
    this.reference = new Growing(line(0.8));
    this.points = new Growing(new THREE.Points(new THREE.BufferGeometry(), new THREE.PointsMaterial({ vertexColors: true, size: 2, sizeAttenuation: false })));
    this.path.object.renderOrder = 2;  // over the reference, where both are one
    this.path.object.material.transparent = true;
    this.scene.add(this.points.object, this.reference.object, this.path.object, this.makeVehicle(), this.makeEllipsoid());
    this.palette = verdictColours.map((c) => new THREE.Color(c));
    this.palette[1] = new THREE.Color("#ffb000");
    this.white = new THREE.Color("#e8eef4");
    this.controls();
    new ResizeObserver(() => this.resize()).observe(element);
    this.resize();
  }

  makeVehicle() {
    const w = 0.32, h = 0.22, d = 0.6;
    const corners = [[d, w, h], [d, -w, h], [d, -w, -h], [d, w, -h]].map((c) => new THREE.Vector3(...c));
    const lines = [];
    corners.forEach((c, i) => lines.push(new THREE.Vector3(), c, c, corners[(i + 1) % 4]));
    this.vehicle = new THREE.LineSegments(new THREE.BufferGeometry().setFromPoints(lines), new THREE.LineBasicMaterial({ color: 0x57c7ff }));
    this.vehicle.frustumCulled = false;
    return this.vehicle;
  }

  makeEllipsoid() {
    this.ellipsoid = new THREE.Mesh(new THREE.SphereGeometry(1, 20, 14), new THREE.MeshBasicMaterial({ color: 0xcc79a7, wireframe: true, transparent: true, opacity: 0.45 }));
    this.ellipsoid.matrixAutoUpdate = false;
    this.ellipsoid.frustumCulled = false;
    this.ellipsoid.visible = false;
    return this.ellipsoid;
  }

  controls() {
    const canvas = this.renderer.domElement;
    let last = null;
    canvas.addEventListener("contextmenu", (e) => e.preventDefault());
    canvas.addEventListener("pointerdown", (e) => { last = e; canvas.setPointerCapture(e.pointerId); });
    canvas.addEventListener("pointerup", () => { last = null; });
    canvas.addEventListener("pointermove", (e) => {
      if (!last) return;
      const dx = e.clientX - last.clientX, dy = e.clientY - last.clientY;
      if (e.buttons === 2 || e.shiftKey) {
        const k = this.distance / canvas.clientHeight, s = Math.sin(this.azimuth), c = Math.cos(this.azimuth);
        this.target.x += k * (dx * s + dy * -c); this.target.y += k * (-dx * c + dy * -s);
        this.onFree?.();
      } else {
        this.azimuth -= dx * 0.008;
        this.elevation = Math.max(-1.5, Math.min(Math.PI / 2 - 1e-3, this.elevation + dy * 0.008));
      }
      last = e;
      this.render(true);
    });
    canvas.addEventListener("wheel", (e) => {
      e.preventDefault();
      this.distance = Math.max(0.5, Math.min(5000, this.distance * Math.exp(e.deltaY * 0.0012)));
      this.render(true);
    }, { passive: false });
  }

  clear() {
    for (const g of [this.path, this.reference, this.points]) g.clear();
    this.cells.clear();
    this.before = null;
  }

  add(records) {
    for (const r of records) {
      const b = this.before;
      if (b && b.ep === r.ep) {
        const colour = this.palette[r.s] ?? this.white;
        this.path.add(b.p, colour); this.path.add(r.p, colour);
        if (b.tr && r.tr) { this.reference.add(b.tr, this.white); this.reference.add(r.tr, this.white); }
      }
      if (this.path.count >= mostWay) { this.path.halve(this.palette[1]); this.reference.halve(this.white); }
      this.before = r;
      if (r.pt) this.addPoints(r);
    }
    this.render();
  }

  addPoints(r) {
    for (let k = 0; k + 2 < r.pt.length; k += 3) {
      const [x, y, z] = r.pt.slice(k, k + 3);
      const key = `${Math.round(x / cell)},${Math.round(y / cell)},${Math.round(z / cell)}`;
      if (this.cells.has(key)) continue;
      const t = Math.max(0, Math.min(1, (z - r.p[2] + 1.5) / 3)), colour = { r: 0.25 + 0.3 * t, g: 0.42 + 0.35 * t, b: 0.5 - 0.15 * t };
      let at = this.points.count;
      if (at < mostPoints) {
        this.points.add([x, y, z], colour);
      } else {
        const [oldest, number] = this.cells.entries().next().value;
        this.cells.delete(oldest);
        this.points.put((at = number), [x, y, z], colour);
      }
      this.cells.set(key, at);
    }
  }

  // The frame that is shown.
  set(record) {
    this.record = record;
    this.render();
  }

  above() { this.elevation = Math.PI / 2 - 1e-3; this.azimuth = Math.PI; this.fit(); this.render(); }
  behind() { this.elevation = 0.5; this.azimuth = this.heading() + Math.PI; this.distance = 12; this.render(); }
  heading() {
    if (!this.record) return 0;
    const [w, x, y, z] = this.record.o;
    return Math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z));
  }
  // All of the way into the view.
  fit() {
    if (this.path.count === 0) return;
    const box = new THREE.Box3().setFromArray(this.path.places.subarray(0, 3 * this.path.count));
    const size = box.getSize(new THREE.Vector3());
    this.distance = Math.max(4, 1.35 * Math.max(size.x, size.y / this.camera.aspect, 1));
    if (!this.follow) box.getCenter(this.target); else this.distance *= 1.6;
  }

  resize() {
    const { clientWidth: w, clientHeight: h } = this.element;
    if (w === 0 || h === 0) return;
    const ratio = this.software ? 1 : window.devicePixelRatio || 1, key = `${w},${h},${ratio}`;
    if (key === this.sizeKey) return;
    this.sizeKey = key;
    this.renderer.setPixelRatio(ratio);
    this.renderer.setSize(w, h, false);
    this.labels.width = w; this.labels.height = h;
    this.camera.aspect = w / h;
    this.camera.updateProjectionMatrix();
    this.render();
  }

  // Soon. By the hand at once; while it plays, where the processor draws, more seldom: the image beside it comes first.
  render(byHand = false) {
    this.soonest = Math.min(this.soonest ?? Infinity, byHand || !this.software ? 0 : (this.drawnAt ?? 0) + softwarePeriod);
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame((now) => this.drawIfDue(now));
  }

  drawIfDue(now) {
    if (now < this.soonest) { requestAnimationFrame((later) => this.drawIfDue(later)); return; }
    this.waiting = false;
    this.soonest = Infinity;
    this.drawnAt = now;
    this.draw();
  }

  draw() {
    const r = this.record;
    if (r) {
      this.vehicle.position.set(...r.p);
      this.vehicle.quaternion.set(r.o[1], r.o[2], r.o[3], r.o[0]);
      this.vehicle.scale.setScalar(Math.max(1, this.distance / 25));
      if (this.follow) this.target.set(...r.p);
      this.placeEllipsoid(r);
    }
    const c = Math.cos(this.elevation);
    this.camera.position.set(this.target.x + this.distance * c * Math.cos(this.azimuth), this.target.y + this.distance * c * Math.sin(this.azimuth), this.target.z + this.distance * Math.sin(this.elevation));
    this.camera.lookAt(this.target);
    for (const g of [this.path, this.reference, this.points]) g.flush();
    this.placeGrid();
    this.renderer.render(this.scene, this.camera);
    this.drawLabels();
  }

  // Drawn larger where it could not be seen, with a note.
  placeEllipsoid(r) {
    const sigma = sigmaOfPlace(r);
    this.ellipsoid.visible = sigma > 0;
    if (!(sigma > 0)) { this.legendText = ""; return; }
    let times = 1;
    while (times < 1e6 && sigma * times < 0.02 * this.distance) times *= 10;
    const L = cholesky(r.cv), k = times;
    this.ellipsoid.matrix.set(k * L[0][0], 0, 0, r.p[0], k * L[1][0], k * L[1][1], 0, r.p[1], k * L[2][0], k * L[2][1], k * L[2][2], r.p[2], 0, 0, 0, 1);
    this.legendText = `1σ ${lengthText(sigma)}${times > 1 ? ` (drawn × ${times})` : ""}`;
  }

  // Lines at round numbers of metres in the plane of the start, about what is looked at.
  placeGrid() {
    const steps = [0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];
    const step = steps.find((s) => s >= this.distance / 8) ?? 1000;
    const cx = Math.round(this.target.x / step) * step, cy = Math.round(this.target.y / step) * step;
    const key = `${step},${cx},${cy}`;
    this.grid = { step, cx, cy };
    if (key === this.gridKey) return;
    this.gridKey = key;
    if (this.gridLines) { this.scene.remove(this.gridLines); this.gridLines.geometry.dispose(); }
    const n = 14, places = [], colours = [];
    const put = (x0, y0, x1, y1, axis) => { places.push(x0, y0, 0, x1, y1, 0); const c = axis ? [0.1, 0.16, 0.24] : [0.014, 0.022, 0.034]; colours.push(...c, ...c); };
    for (let k = -n; k <= n; ++k) {
      const x = cx + k * step, y = cy + k * step;
      for (let j = -n; j < n; ++j) {  // in pieces: a long line through the camera is lost
        put(x, cy + j * step, x, cy + (j + 1) * step, Math.abs(x) < step / 2);
        put(cx + j * step, y, cx + (j + 1) * step, y, Math.abs(y) < step / 2);
      }
    }
    const g = new THREE.BufferGeometry();
    g.setAttribute("position", new THREE.Float32BufferAttribute(places, 3));
    g.setAttribute("color", new THREE.Float32BufferAttribute(colours, 3));
    this.gridLines = new THREE.LineSegments(g, this.gridMaterial ??= new THREE.LineBasicMaterial({ vertexColors: true }));
    this.gridLines.frustumCulled = false;
    this.scene.add(this.gridLines);
  }

  drawLabels() {
    const context = this.labels.getContext("2d");
    const { width: w, height: h } = this.labels;
    context.clearRect(0, 0, w, h);
    context.font = "11px system-ui, sans-serif";
    context.fillStyle = "#93a1b0";
    const v = new THREE.Vector3();
    const { step, cx, cy } = this.grid;
    // None over another one: far lines lie close together.
    const taken = [];
    const label = (x, y, text) => {
      v.set(x, y, 0).project(this.camera);
      if (v.z > 1 || Math.abs(v.x) > 0.97 || Math.abs(v.y) > 0.95) return;
      const at = [(v.x * 0.5 + 0.5) * w + 3, (-v.y * 0.5 + 0.5) * h - 3];
      if (taken.some(([a, b]) => Math.abs(a - at[0]) < 40 && Math.abs(b - at[1]) < 13)) return;
      taken.push(at);
      context.fillText(text, ...at);
    };
    const number = (m) => (step < 1 ? m.toFixed(1) : m.toFixed(0));
    for (const k of [0, 1, -1, 2, -2, 3, -3, 4, -4, 5, -5, 6, -6, 7, -7, 8, -8]) {
      label(cx + k * step, Math.abs(cy) > 6 * step ? cy : 0, `${number(cx + k * step)} m`);
      if (Math.abs(cy + k * step) > step / 2) label(Math.abs(cx) > 6 * step ? cx : 0, cy + k * step, `${number(-(cy + k * step))} m`);
    }
    this.drawCompass(context, w);
    if (this.legendText) { context.fillStyle = "#e6b5d2"; context.fillText(this.legendText, 10, h - 10); }
  }

  // Axes of the start as seen from here: forward, right and up.
  drawCompass(context, w) {
    const x = w - 42, y = 42, v = new THREE.Vector3();
    context.lineWidth = 2;
    const taken = [];
    for (const [axis, name, colour] of [[[0, 0, 1], "up", "#35e0a1"], [[1, 0, 0], "forward", "#ffb000"], [[0, -1, 0], "right", "#57c7ff"]]) {
      v.set(...axis).transformDirection(this.camera.matrixWorldInverse);
      context.strokeStyle = context.fillStyle = colour;
      context.beginPath(); context.moveTo(x, y); context.lineTo(x + 26 * v.x, y - 26 * v.y); context.stroke();
      const t = context.measureText(name).width, at = [Math.min(x + 32 * v.x - t / 2, w - t - 2), y - 34 * v.y + 4];
      if (Math.hypot(v.x, v.y) < 0.4 || taken.some(([a, b]) => Math.abs(a - at[0]) < 38 && Math.abs(b - at[1]) < 11)) continue;
      taken.push(at);
      context.fillText(name, ...at);
    }
  }
}
