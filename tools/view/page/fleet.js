// SPDX-License-Identifier: BSD-3-Clause
// The report on a fleet: many recordings, some configurations. Tables sort by a click on a head.
import { escape } from "./why.js";

const colours = ["#56b4e9", "#e69f00", "#1f9e77", "#cc79a7", "#f0e442", "#d55e00", "#8b98a5"];
const colourOf = (k) => colours[k % colours.length];
const mostRows = 100;

const number = (v, digits = 4) => (v === null || v === undefined ? "-" : typeof v === "number" ? `${+v.toPrecision(digits)}` : v);
const link = (text, page) => ({ html: page ? `<a href="${escape(page)}">${escape(text)}</a>` : escape(text), sort: text });

// cells: text, number, or { html, sort }.
function fill(body, rows) {
  body.innerHTML = rows.map(({ cells, failed }) => `<tr class="${failed ? "failed" : ""}">${cells.map((c) => `<td${typeof (c?.sort ?? c) === "string" ? ' style="text-align:left"' : ""}>${c?.html ?? escape(`${number(c)}`)}</td>`).join("")}</tr>`).join("");
}
function sortable(box, head, rows) {
  box.style.overflowX = "auto";
  box.innerHTML = `<table class="plain"><thead><tr>${head.map((h) => `<th style="cursor:pointer;vertical-align:bottom">${escape(h)}</th>`).join("")}</tr></thead><tbody></tbody></table>`;
  const body = box.querySelector("tbody");
  fill(body, rows);
  let last = -1, sign = 1;
  const value = (row, k) => row.cells[k]?.sort ?? row.cells[k];
  box.querySelectorAll("th").forEach((th, k) => th.addEventListener("click", () => {
    sign = last === k ? -sign : 1;
    last = k;
    const nothing = (v) => v === null || v === undefined;
    fill(body, [...rows].sort((a, b) => {
      const x = value(a, k), y = value(b, k);
      if (nothing(x) || nothing(y)) return nothing(x) - nothing(y);
      return sign * (typeof x === "number" && typeof y === "number" ? x - y : `${x}`.localeCompare(`${y}`));
    }));
  }));
}

function configurations(fleet, panel) {
  const names = ["segments", "rotation", "end", "ATE", "quality", "time"];
  const rows = fleet.configurations.map((c) => ({ cells: [c.name, c.units, c.frames, c.failed, c.distance_m, ...names.flatMap((n) => [c.figures[n]?.median, c.figures[n]?.p95])] }));
  sortable(panel("Configurations", ""), ["configuration", "units", "frames", "failed frames", "way [m]", ...names.flatMap((n) => [`${n}: median`, "95 %"])], rows);
}

function failures(fleet, panel) {
  for (const reason of fleet.failures) {
    const box = panel(`Without a result: ${reason.units.length} x ${reason.what}`, "");
    sortable(box, ["recording", "configuration", "why", "on"], reason.units.slice(0, mostRows).map((u) => ({ cells: [u.recording, u.configuration, u.line, u.host ?? ""] })));
  }
}

const worse = (f) => (f.times_worse === null ? "worse" : `× ${f.times_worse.toFixed(2)}`);
function comparisons(fleet, panel) {
  for (const { a, b, comparison } of fleet.comparisons) {
    const row = (run) => (f) => ({ failed: f.beyond_gate, cells: [run.name, f.name, f.a, f.b, f.unit, worse(f)] });
    const beyond = comparison.runs.filter((r) => r.beyond_gate);
    const box = panel(`${b} against ${a}: ${beyond.length} of ${comparison.runs.length} recordings beyond the gate of ${comparison.gate}`, "");
    const rows = comparison.in_all.figures.map(row(comparison.in_all));
    for (const run of beyond.slice(0, mostRows)) {
      if (run.missing_in) rows.push({ failed: true, cells: [run.name, `missing in ${run.missing_in === "B" ? b : a}`, null, null, "", ""] });
      else rows.push(...run.figures.filter((f) => f.beyond_gate).map(row(run)));
    }
    sortable(box, ["recording", "figure", "baseline", "here", "", "worse by"], rows);
  }
}

// A step line a configuration over the bins.
function histogram({ figure, unit, edges, series }) {
  const w = 360, h = 150, left = 30, bottom = 22, most = Math.max(1, ...series.flatMap((s) => s.counts));
  const x = (k) => left + (k / (edges.length - 1)) * (w - left - 6), y = (n) => 6 + (1 - n / most) * (h - bottom - 6);
  const lines = series.map((s, k) => `<path fill="${colourOf(k)}" fill-opacity="0.15" stroke="${colourOf(k)}" stroke-width="1.5" d="M${x(0)} ${y(0)}${s.counts.map((n, i) => `V${y(n).toFixed(1)}H${x(i + 1).toFixed(1)}`).join("")}V${y(0)}"><title>${escape(s.configuration)}</title></path>`);
  const text = (at, v, anchor) => `<text x="${at}" y="${h - 6}" text-anchor="${anchor}">${escape(number(v, 3))}</text>`;
  return `<figure style="margin:0"><figcaption>${escape(figure)} [${escape(unit)}]</figcaption><svg viewBox="0 0 ${w} ${h}" style="width:100%;font-size:11px" fill="#93a1b0"><path stroke="#232d38" d="M${left} ${y(0)}H${w - 6}M${left} ${y(most)}H${w - 6}"/>${lines.join("")}${text(left, edges[0], "start")}${text(w - 6, edges.at(-1), "end")}<text x="${left - 4}" y="14" text-anchor="end">${most}</text></svg></figure>`;
}
function distributions(fleet, panel) {
  if (!fleet.distributions.length) return;
  const legend = fleet.configurations.map((c, k) => `<span><i style="background:${colourOf(k)}"></i>${escape(c.name)}</span>`).join("");
  panel("Distributions over the recordings", `<div class="legend">${legend}</div><div style="display:grid;grid-template-columns:repeat(auto-fill,minmax(300px,1fr));gap:10px">${fleet.distributions.map(histogram).join("")}</div>`);
}

export function drawFleet(fleet, panel) {
  configurations(fleet, panel);
  failures(fleet, panel);
  comparisons(fleet, panel);
  distributions(fleet, panel);
  if (fleet.worst.length) {
    sortable(panel("The worst frames", ""), ["recording", "configuration", "frame", "verdict", "quality", "why"],
      fleet.worst.map((f) => ({ cells: [link(f.recording, f.page), f.configuration, f.index, f.status, f.quality, f.failed_checks.join(", ")] })));
  }
  if (fleet.reasons.length) {
    sortable(panel("Why frames were refused", ""), ["check", ...fleet.configurations.map((c) => c.name)],
      fleet.reasons.map((r) => ({ cells: [r.check, ...fleet.configurations.map((c) => r.frames[c.name] ?? 0)] })));
  }
  const names = ["segments", "rotation", "end", "ATE", "quality", "inliers", "time"];
  sortable(panel(`Recordings (${fleet.table.length} units)`, ""), ["recording", "configuration", "frames", "failed", "skipped", "way [m]", ...names],
    fleet.table.map((u) => ({ cells: [link(u.recording, u.page), u.configuration, u.frames, u.failed, u.skipped, u.distance_m, ...names.map((n) => u.figures[n])] })));
}
