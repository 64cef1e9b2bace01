// SPDX-License-Identifier: BSD-3-Clause
// The way from above, with its reference: metres, one as long on both axes.
import { verdictColours } from "./colours.js";

// paths: [{points: [[right, forward], ...], colour, width, dashed}]; marks: [{x, y, colour, shape}].
export class MapPanel {
  constructor(element, onHover, onClick) {
    this.canvas = document.createElement("canvas");
    element.append(this.canvas);
    this.paths = []; this.marks = [];
    new ResizeObserver(() => this.draw()).observe(element);
    const at = (e) => { const b = this.canvas.getBoundingClientRect(); return this.nearest(e.clientX - b.left, e.clientY - b.top); };
    this.canvas.addEventListener("mousemove", (e) => onHover?.(at(e), e));
    this.canvas.addEventListener("mouseleave", (e) => onHover?.(-1, e));
    this.canvas.addEventListener("click", (e) => onClick?.(at(e)));
  }

  set(paths, marks) { this.paths = paths; this.marks = marks; this.draw(); }
  // Index into the first path.
  nearest(x, y) {
    let best = -1, least = 900;
    (this.paths[0]?.points ?? []).forEach((p, i) => { const [u, v] = this.place(p), d = (u - x) ** 2 + (v - y) ** 2; if (d < least) { least = d; best = i; } });
    return best;
  }
  place([x, y]) { return [this.ox + x * this.scale, this.oy - y * this.scale]; }

  draw() {
    const ratio = window.devicePixelRatio || 1, w = this.canvas.clientWidth, h = this.canvas.clientHeight;
    if (!w || !this.paths.length) return;
    this.canvas.width = w * ratio; this.canvas.height = h * ratio;
    const c = this.canvas.getContext("2d");
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    let [x0, x1, y0, y1] = [Infinity, -Infinity, Infinity, -Infinity];
    for (const p of this.paths) for (const [x, y] of p.points) { x0 = Math.min(x0, x); x1 = Math.max(x1, x); y0 = Math.min(y0, y); y1 = Math.max(y1, y); }
    const margin = 46, span = Math.max(x1 - x0, y1 - y0, 1e-3);
    const room = { w: w - margin - 16, h: h - margin - 14 };
    this.scale = Math.min(room.w / Math.max(x1 - x0, span * 0.15), room.h / Math.max(y1 - y0, span * 0.15)) * 0.94;
    this.ox = margin + room.w / 2 - ((x0 + x1) / 2) * this.scale;
    this.oy = 14 + room.h / 2 + ((y0 + y1) / 2) * this.scale;
    this.axes(c, w, h, margin);
    for (const p of [...this.paths].reverse()) this.line(c, p);
    for (const m of this.marks) this.mark(c, m);
  }

  axes(c, w, h, margin) {
    const raw = 70 / this.scale, power = 10 ** Math.floor(Math.log10(raw));
    const step = [1, 2, 5, 10].map((k) => k * power).find((s) => s >= raw);
    c.font = "11px system-ui, sans-serif"; c.fillStyle = "#93a1b0"; c.strokeStyle = "#232d38"; c.lineWidth = 1;
    const text = (v) => +v.toPrecision(6) + "";
    for (let k = Math.ceil((margin - this.ox) / this.scale / step); this.ox + k * step * this.scale < w - 8; ++k) {
      const x = this.ox + k * step * this.scale;
      c.beginPath(); c.moveTo(x, 8); c.lineTo(x, h - margin + 10); c.stroke();
      c.fillText(text(k * step), x - 8, h - margin + 24);
    }
    for (let k = Math.ceil((this.oy - (h - margin + 6)) / this.scale / step); this.oy - k * step * this.scale > 10; ++k) {
      const y = this.oy - k * step * this.scale;
      c.beginPath(); c.moveTo(margin - 6, y); c.lineTo(w - 8, y); c.stroke();
      c.fillText(text(k * step), 6, y + 4);
    }
    c.fillText("right [m]", w / 2 - 20, h - 6);
    c.save(); c.translate(w - 4, h / 2 + 26); c.rotate(-Math.PI / 2); c.fillText("forward [m]", 0, 0); c.restore();
  }

  line(c, p) {
    c.strokeStyle = p.colour; c.lineWidth = p.width; c.setLineDash(p.dashed ? [6, 5] : []);
    c.lineJoin = "round";
    c.beginPath();
    p.points.forEach((q, i) => { const [x, y] = this.place(q); if (i === 0) c.moveTo(x, y); else c.lineTo(x, y); });
    c.stroke();
    c.setLineDash([]);
  }

  mark(c, m) {
    const [x, y] = this.place([m.x, m.y]);
    c.strokeStyle = c.fillStyle = m.colour; c.lineWidth = 2;
    c.beginPath();
    if (m.shape === "cross") { c.moveTo(x - 4, y - 4); c.lineTo(x + 4, y + 4); c.moveTo(x - 4, y + 4); c.lineTo(x + 4, y - 4); c.stroke(); }
    else if (m.shape === "ring") { c.arc(x, y, 6, 0, 7); c.stroke(); }
    else { c.rect(x - 4, y - 4, 8, 8); c.fill(); }
  }
}

export const failedMarks = (records) => records.filter((r) => r.s !== 1 && r.s !== 0).map((r) => ({ x: -r.p[1], y: r.p[0], colour: verdictColours[r.s], shape: "cross" }));
