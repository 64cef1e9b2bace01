// SPDX-License-Identifier: BSD-3-Clause
// When: the ribbon of verdicts, and charts over time that all show the same moment.
import uPlot from "./vendor/uPlot.esm.js";
import { verdictColours } from "./colours.js";
import { sigmaOfPlace } from "./record.js";

// Worst of the verdicts in a column: a single failed frame among thousands must be seen.
export function drawRibbon(canvas, list, extent) {
  const ratio = window.devicePixelRatio || 1;
  const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
  if (width === 0) return;
  if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; }
  const context = canvas.getContext("2d");
  context.fillStyle = "#1c242e";
  context.fillRect(0, 0, width, height);
  const columns = new Int8Array(width).fill(-1);
  const span = Math.max(1, extent.end - extent.first);
  for (const r of list) {
    const from = Math.floor(((r.n - extent.first) * width) / span), to = Math.max(from + 1, Math.floor(((r.n + 1 - extent.first) * width) / span));
    for (let x = from; x < to && x < width; ++x) {
      const worst = columns[x];
      if (worst < 0 || (r.s !== 1 && (worst === 1 || worst === 0))) columns[x] = r.s;
    }
  }
  for (let x = 0; x < width; ) {
    let end = x + 1;
    while (end < width && columns[end] === columns[x]) ++end;
    if (columns[x] >= 0) { context.fillStyle = verdictColours[columns[x]]; context.fillRect(x, 2 * ratio, end - x, height - 4 * ratio); }
    x = end;
  }
}

export const chartKinds = [
  { title: "stage times [ms]", series: [["rectify", "#93a1b0", (r) => r.tm[0] / 1000], ["stereo", "#57c7ff", (r) => r.tm[1] / 1000], ["odometry", "#ffb000", (r) => r.tm[2] / 1000]] },
  { title: "latency [ms]", when: (list) => list.some((r) => r.lt), series: [["grabbed to sent", "#cc79a7", (r) => (r.lt ? r.lt / 1000 : null)]] },
  { title: "reprojection error [px]", series: [["found", "#ffb000", (r) => (r.s === 1 ? r.e : null)], ["expected", "#93a1b0", (r) => r.ee || null]] },
  { title: "features", series: [["inliers", "#35e0a1", (r) => r.c[3]], ["matches", "#57c7ff", (r) => r.c[1]]] },
  { title: "sigma [m]", series: [["place", "#cc79a7", sigmaOfPlace], ["step", "#93a1b0", (r) => (r.s === 1 ? r.sg : null)]] },
  { title: "self-check [px]", series: [["disparity", "#ffb000", (r) => r.sc[0]], ["rows", "#57c7ff", (r) => r.sc[2]]] },
];

export class Charts {
  // choose(number): a place in a chart was clicked.
  constructor(element, choose, height = 112) {
    this.element = element;
    this.choose = choose;
    this.height = height;
    this.charts = [];
    new ResizeObserver(() => this.resize()).observe(element);
  }

  make(kinds) {
    for (const c of this.charts) { c.plot.destroy(); c.box.remove(); }
    this.element.style.setProperty("--charts", kinds.length);
    this.charts = kinds.map((kind) => {
      const box = document.createElement("div");
      box.className = "chart";
      this.element.append(box);
      const axis = { stroke: "#93a1b0", grid: { stroke: "#232d38", width: 1 }, ticks: { stroke: "#232d38", size: 4 }, font: "11px system-ui" };
      const plot = new uPlot({
        width: Math.max(80, box.clientWidth), height: this.height, title: kind.title,
        scales: { x: { time: false } }, cursor: { drag: { x: true, y: false }, points: { size: 5 }, sync: { key: "when" } },
        legend: { show: true, live: true },
        axes: [{ ...axis, size: 22, space: 60, values: (_, v) => v.map((x) => `${+x.toFixed(2)} s`) }, { ...axis, size: 44, space: 24 }],
        series: [{ label: "t", value: (_, v) => (v === null ? "" : v.toFixed(2) + " s") }, ...kind.series.map(([label, stroke]) => ({ label, stroke, width: 1.2, points: { show: false }, value: (_, v) => (v === null || v === undefined ? "" : +v.toPrecision(3) + "") }))],
      }, [[], ...kind.series.map(() => [])], box);
      const line = document.createElement("div");
      line.style.cssText = "position:absolute;top:0;bottom:0;width:1px;background:#ffb000;pointer-events:none;transform:translateX(-9999px)";
      plot.over.append(line);
      this.clicks(plot);
      return { kind, box, plot, line };
    });
    this.made = kinds;
    requestAnimationFrame(() => this.resize());
  }

  clicks(plot) {
    let down = null;
    plot.over.addEventListener("mousedown", (e) => { down = e.clientX; });
    plot.over.addEventListener("click", (e) => {
      if (down !== null && Math.abs(e.clientX - down) > 3) return;  // that was a zoom
      const x = plot.posToVal(e.clientX - plot.over.getBoundingClientRect().left, "x");
      this.choose(this.numberAt(x));
    });
  }

  numberAt(t) {
    const list = this.list, us = t * 1e6 + this.t0;
    if (!list?.length) return 0;
    let a = 0, b = list.length - 1;
    while (a < b) { const m = (a + b) >> 1; if (list[m].t < us) a = m + 1; else b = m; }
    if (a > 0 && us - list[a - 1].t < list[a].t - us) --a;
    return list[a].n;
  }

  set(list, t0) {
    this.list = list;
    this.t0 = t0;
    this.first = list[0]?.n ?? 0;
    const kinds = chartKinds.filter((k) => !k.when || k.when(list)).slice(0, 6);
    if (!this.made || kinds.length !== this.made.length) this.make(kinds);
    const t = list.map((r) => (r.t - t0) / 1e6);
    for (const c of this.charts) {
      const zoomed = c.plot.scales.x.min > (c.plot.data[0][0] ?? 0) || c.plot.scales.x.max < (c.plot.data[0].at(-1) ?? 0);
      c.plot.setData([t, ...c.kind.series.map(([, , of]) => list.map(of))], !zoomed);
      if (zoomed) c.plot.redraw();
    }
    this.mark(this.marked);
  }

  // The frame that is shown. Nothing here may ask for the layout: that would be made anew for each chart.
  mark(record, withTexts = true) {
    this.marked = record;
    const ratio = window.devicePixelRatio || 1;
    for (const c of this.charts) {
      const x = record && c.plot.data[0].length ? c.plot.valToPos((record.t - this.t0) / 1e6, "x") : -1;
      c.line.style.transform = `translateX(${x >= 0 && x <= c.plot.bbox.width / ratio ? x : -9999}px)`;
      if (withTexts && record && c.plot.cursor.left < 0) c.plot.setLegend({ idx: this.indexOf(record) }, false);
    }
  }

  indexOf(record) { return Math.max(0, Math.min(this.charts[0].plot.data[0].length - 1, record.n - this.first)); }

  resize() {
    for (const c of this.charts) c.plot.setSize({ width: Math.max(80, c.box.clientWidth), height: this.height });
    this.mark(this.marked);
  }
}
