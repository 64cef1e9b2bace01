// SPDX-License-Identifier: BSD-3-Clause
// A report: a run, a trajectory's evaluation, a comparison or a fleet, from the data in the file itself.
import uPlot from "./vendor/uPlot.esm.js";
import { markIcon, roles, verdictColours } from "./colours.js";
import { drawFleet } from "./fleet.js";
import { unpackFeatures } from "./frame.js";
import { failedMarks, MapPanel } from "./map.js";
import { drawFeatures, drawMovers } from "./picture.js";
import { Charts, drawRibbon } from "./when.js";
import { escape, verdictChip, whyHtml } from "./why.js";

const data = JSON.parse(document.getElementById("data").textContent);
const records = data.records ?? [];
const content = document.getElementById("content");
const tip = document.getElementById("tip");
content.style.display = "contents";
document.getElementById("title").textContent = data.title ?? "";
document.title = `${data.title ?? "cliquevo"} - report`;

function panel(title, html = "", id = "") {
  const section = document.createElement("section");
  section.className = "panel";
  if (id) section.id = `${id}-panel`;
  section.innerHTML = `<div class="bar"><h2>${escape(title)}</h2></div><div ${id ? `id="${id}"` : 'class="pad"'}>${html}</div>`;
  (panel.into ?? content).append(section);
  return section.lastElementChild;
}
function columns(body) {
  const box = document.createElement("div");
  box.className = "columns";
  content.append(box);
  panel.into = box;
  body();
  panel.into = null;
}

// The frame under the pointer, with the nearest small picture there is.
function showTip(r, event) {
  if (!r) { tip.style.display = "none"; return; }
  const thumb = (data.thumbnails ?? []).reduce((best, t) => (!best || Math.abs(t.n - r.n) < Math.abs(best.n - r.n) ? t : best), null);
  const key = `${r.n}`;
  if (tip.dataset.n !== key) {
    tip.dataset.n = key;
    const failed = data.checks.filter((_, k) => (r.fm >> k) & 1).map((name) => { const k = data.checks.indexOf(name), [, v, b] = r.ck[k]; return `${escape(name)} ${+v.toPrecision(3)} of ${+b.toPrecision(3)}`; });
    tip.innerHTML = (thumb ? `<img alt="" src="data:image/jpeg;base64,${thumb.jpeg}">` : "") +
      `${verdictChip(r.s, data.verdicts)} frame ${r.i}, ${((r.t - records[0].t) / 1e6).toFixed(2)} s<br>` +
      `${r.c[3]} inliers of ${r.c[0]} features, ${r.e.toFixed(3)} px, quality ${r.q}<br>${(r.tm.reduce((a, b) => a + b) / 1000).toFixed(2)} ms` +
      (failed.length ? `<br><span class="warn">${failed.join(", ")}</span>` : "") + (thumb && thumb.n !== r.n ? `<br><span class="dim">picture of frame ${records[thumb.n]?.i}</span>` : "");
  }
  tip.style.display = "block";
  const w = tip.offsetWidth, h = tip.offsetHeight;
  tip.style.left = `${Math.min(event.clientX + 16, window.innerWidth - w - 8)}px`;
  tip.style.top = `${Math.max(4, Math.min(event.clientY + 16, window.innerHeight - h - 8))}px`;
}

function drawMap() {
  const box = panel("Where: from above", "", "map");
  const way = records.length ? records.map((r) => [-r.p[1], r.p[0]]) : data.way;
  const paths = [{ points: way, colour: "#ffb000", width: 2.5 }];
  if (data.reference?.way?.length) paths.push({ points: data.reference.way, colour: "#e8eef4", width: 2, dashed: true });
  const map = new MapPanel(box, (i, e) => showTip(records[i], e));
  const marks = failedMarks(records);
  marks.push({ x: way[0][0], y: way[0][1], colour: "#35e0a1", shape: "ring" }, { x: way.at(-1)[0], y: way.at(-1)[1], colour: "#dce3ea", shape: "square" });
  map.set(paths, marks);
  box.insertAdjacentHTML("afterend", `<div class="legend"><span><i style="background:#ffb000"></i>estimate</span>${paths.length > 1 ? '<span><i style="background:#e8eef4"></i>reference</span>' : ""}<span>ring: start, square: end${records.length ? ", crosses: failed frames" : ""}</span><span>axes: the camera's in its first frame</span></div>`);
}

function drawError() {
  const { distance, error } = data.reference;
  const box = panel("Error over distance", "", "error");
  box.style.padding = "8px";
  const plot = new uPlot({
    width: box.clientWidth - 16, height: 410, scales: { x: { time: false } },
    axes: [{ stroke: "#93a1b0", grid: { stroke: "#232d38" }, values: (_, v) => v.map((x) => `${x} m`) }, { stroke: "#93a1b0", grid: { stroke: "#232d38" }, size: 74, values: (_, v) => v.map((x) => `${+x.toPrecision(6)} m`) }],
    series: [{ label: "distance", value: (_, v) => (v === null ? "" : v.toFixed(2) + " m") }, { label: data.reference.aligned ? "off after alignment" : "off", stroke: "#ffb000", width: 1.6, points: { show: false }, value: (_, v) => (v === null ? "" : v.toFixed(4) + " m") }],
  }, [distance, error], box);
  plot.over.addEventListener("mousemove", (e) => showTip(records[data.reference.index[plot.cursor.idx ?? 0]], e));
  plot.over.addEventListener("mouseleave", (e) => showTip(null, e));
  new ResizeObserver(() => plot.setSize({ width: box.clientWidth - 16, height: 410 })).observe(box);
}

function drawTime() {
  const box = panel("When", `<div id="ribbon"><canvas></canvas></div><div class="legend">${data.verdicts.map((name, k) => (k ? `<span><i style="background:${verdictColours[k]}"></i>${escape(name)}</span>` : "")).join("")}</div><div id="charts"></div>`, "time");
  const ribbon = box.querySelector("#ribbon"), canvas = ribbon.querySelector("canvas");
  const extent = { first: 0, end: records.length };
  new ResizeObserver(() => drawRibbon(canvas, records, extent)).observe(ribbon);
  const at = (e) => { const b = ribbon.getBoundingClientRect(); return records[Math.floor(((e.clientX - b.left) / b.width) * records.length)]; };
  ribbon.addEventListener("mousemove", (e) => showTip(at(e), e));
  ribbon.addEventListener("mouseleave", (e) => showTip(null, e));
  const charts = new Charts(box.querySelector("#charts"), () => {}, 150);
  charts.set(records, records[0].t);
  for (const c of charts.charts) {
    c.plot.over.addEventListener("mousemove", (e) => showTip(records[c.plot.cursor.idx ?? -1], e));
    c.plot.over.addEventListener("mouseleave", (e) => showTip(null, e));
  }
}

async function drawWorst() {
  const box = panel("The worst frames", "", "worst");
  box.insertAdjacentHTML("beforebegin", `<div class="legend">${roles.map((r) => `<span>${markIcon(r)}${r.name}</span>`).join("")}</div>`);
  for (const worst of data.worst) {
    const r = records[worst.n], figure = document.createElement("figure"), canvas = document.createElement("canvas");
    figure.append(canvas);
    figure.insertAdjacentHTML("beforeend", `<figcaption>frame ${r.i}, ${((r.t - records[0].t) / 1e6).toFixed(2)} s: ${whyHtml(r, data)}</figcaption>`);
    box.append(figure);
    const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
    const features = bytes(worst.features);
    const image = await createImageBitmap(new Blob([bytes(worst.jpeg)], { type: "image/jpeg" }));
    const scale = Math.max(1, 1000 / image.width);
    canvas.width = image.width * scale; canvas.height = image.height * scale;
    const context = canvas.getContext("2d");
    context.drawImage(image, 0, 0, canvas.width, canvas.height);
    drawFeatures(context, unpackFeatures(features.buffer, 0, features.length), scale);
    drawMovers(context, r.mv, scale, canvas.width);
  }
}

function table(rows, head) {
  return `<table class="plain">${head ? `<tr>${head.map((h) => `<th>${escape(h)}</th>`).join("")}</tr>` : ""}${rows.map(({ cells, failed }) => `<tr class="${failed ? "failed" : ""}">${cells.map((c) => `<td>${escape(c)}</td>`).join("")}</tr>`).join("")}</table>`;
}
const number = (v, digits = 4) => (v === null || v === undefined ? "-" : typeof v === "number" ? +v.toPrecision(digits + 2) + "" : v);

function drawComparison() {
  for (const run of [...data.comparison.runs, data.comparison.in_all]) {
    if (run.missing_in) { panel(run.name, `<p class="warn">missing in ${run.missing_in}</p>`); continue; }
    panel(run.name, table(run.figures.map((f) => ({ failed: f.beyond_gate, cells: [f.name, number(f.a, 2), number(f.b, 2), f.unit, f.times_worse === null ? "worse" : `× ${f.times_worse.toFixed(2)}`, f.beyond_gate ? "beyond the gate" : ""] })), ["figure", "A", "B", "", "worse by", ""]));
  }
}

if (data.sentence) panel("Summary", `<p><b>${escape(data.sentence)}</b></p>${(data.lines ?? []).map((l) => `<p class="${l.warn ? "warn" : "dim"}">${escape(l.text)}</p>`).join("")}`, "").parentElement.id = "summary";
if (data.comparison) drawComparison();
if (data.fleet) drawFleet(data.fleet, panel);
columns(() => {
  if (records.length || data.way?.length) drawMap();
  if (data.reference?.distance?.length) drawError();
});
if (records.length) drawTime();
if (data.tables) for (const t of data.tables) panel(t.title, table(t.rows.map((cells) => ({ cells: cells.map((c) => number(c)) })), t.head));
if (data.worst?.length) await drawWorst();
for (const [title, text] of [["Configuration in force", data.configuration], ["Machine and version", data.machine]]) {
  if (text) content.insertAdjacentHTML("beforeend", `<section class="panel"><details><summary>${title}</summary><div class="pad"><pre>${escape(text)}</pre></div></details></section>`);
}
window.cliquevoReport = { data, ready: true };
