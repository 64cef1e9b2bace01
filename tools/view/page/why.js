// SPDX-License-Identifier: BSD-3-Clause
// Why: each check's value beside its bound.
import { verdictColours } from "./colours.js";

// What a check's value is.
const units = {
  inliers: "needed / found", spread: "needed / found", positions: "× noise", disparities: "× noise", contradiction: "of the picture",
  "running ground": "× noise", "hanging camera": "one / other", "found again": "needed / found", "rival motion": "of a rival", uncertainty: "σ / known",
};
const meanings = {
  inliers: "Too few features moved as one: a blank, blurred or dark picture, or a motion that was too fast.",
  spread: "The features lie nearly on a line: they do not fix the motion.",
  positions: "The features scatter about the motion more than this camera's noise explains.",
  disparities: "Their disparities do not fit the motion.",
  contradiction: "Much of the picture moved otherwise: something large moves by itself.",
  "running ground": "Surfaces change from frame to frame, as water does.",
  "hanging camera": "One camera's picture moves, the other one stands: it repeats an image.",
  "found again": "Too few of the features of the frame before were found again.",
  "rival motion": "A second motion is as well supported: which of them is the world's?",
  uncertainty: "By its own covariance the motion is hardly known.",
};

const escape = (text) => String(text).replace(/[&<>"]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;", '"': "&quot;" })[c]);
const number = (v) => (v === undefined || v === null ? "" : Math.abs(v) >= 1000 ? v.toExponential(1) : +v.toPrecision(3) + "");

export function verdictChip(status, names) {
  return `<span class="chip" style="background:${verdictColours[status] ?? "#555"};color:${status === 6 || status === 2 || status === 3 ? "#000" : "#fff"}">${escape(names[status] ?? status)}</span>`;
}

export function whyHtml(record, checks, verdicts) {
  if (!record) return "";
  const rows = checks.map((name, k) => {
    const [ratio, value, bound] = record.ck[k] ?? [0];
    const failed = (record.fm >> k) & 1, off = ratio === 0 && value === undefined;
    const share = Math.min(100, 50 * ratio);
    return `<tr class="${failed ? "failed" : off ? "off" : ""}"><td>${escape(name)}${off ? "" : ` <small>${units[name] ?? ""}</small>`}</td><td>${number(value)}</td><td>${number(bound)}</td><td>${off ? "" : `<span class="meter${failed ? " failed" : ""}"><b style="width:${share}%"></b><u></u></span>`}</td></tr>`;
  });
  const failed = checks.filter((_, k) => (record.fm >> k) & 1);
  const text = failed.map((name) => `<p class="explain">${escape(name)}: ${escape(meanings[name] ?? "")}</p>`).join("");
  const first = record.s === 0 ? '<p class="explain">The first frame: there is nothing to compare it with.</p>' : "";
  return `<div class="verdict">${verdictChip(record.s, verdicts)}<span class="dim">quality ${record.q} of 100</span></div>` +
    `<table class="checks"><tr><th>check</th><th>value</th><th>bound</th><th>of it</th></tr>${rows.join("")}</table>${text}${first}`;
}
export { escape };
