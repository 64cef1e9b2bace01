// SPDX-License-Identifier: BSD-3-Clause
// Why: each check's value beside its bound.
import { verdictColours } from "./colours.js";

const escape = (text) => String(text).replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);
const number = (v) => (v === undefined || v === null ? "" : Math.abs(v) >= 1000 ? v.toExponential(1) : +v.toPrecision(3) + "");

export function verdictChip(status, names) {
  return `<span class="chip" style="background:${verdictColours[status] ?? "#555"};color:${status === 6 || status === 2 || status === 3 ? "#000" : "#fff"}">${escape(names[status] ?? status)}</span>`;
}

// names: {checks, check_texts, verdicts}, as the view and a report give them; texts: {unit, meaning}, a check each.
export function whyHtml(record, { checks, check_texts: texts, verdicts }) {
  if (!record) return "";
  const rows = checks.map((name, k) => {
    const [ratio, value, bound] = record.ck[k] ?? [0];
    const failed = (record.fm >> k) & 1, off = ratio === 0 && value === undefined;
    const share = Math.min(100, 50 * ratio);
    return `<tr class="${failed ? "failed" : off ? "off" : ""}"><td>${escape(name)}${off ? "" : ` <small>${escape(texts[k].unit)}</small>`}</td><td>${number(value)}</td><td>${number(bound)}</td><td>${off ? "" : `<span class="meter${failed ? " failed" : ""}"><b style="width:${share}%"></b><u></u></span>`}</td></tr>`;
  });
  const text = checks.map((name, k) => ((record.fm >> k) & 1 ? `<p class="explain">${escape(name)}: ${escape(texts[k].meaning)}</p>` : "")).join("");
  const first = record.s === 0 ? '<p class="explain">The first frame: there is nothing to compare it with.</p>' : "";
  return `<div class="verdict">${verdictChip(record.s, verdicts)}<span class="dim">quality ${record.q} of 100</span></div>` +
    `<table class="checks"><tr><th>check</th><th>value</th><th>bound</th><th>of it</th></tr>${rows.join("")}</table>${text}${first}`;
}
export { escape };
