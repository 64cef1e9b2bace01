// SPDX-License-Identifier: BSD-3-Clause
// Health: of a daemon its VO_HEALTH; of a recording how the run went so far.
import { escape } from "./why.js";
import { total } from "./record.js";

const row = (name, value) => (value === "" || value === undefined || value === null ? "" : `<dt>${name}</dt><dd>${escape(value)}</dd>`);
const ms = (us) => (us > 0 ? (us / 1000).toFixed(1) + " ms" : "");

function median(values) { const s = [...values].sort((a, b) => a - b); return s.length ? s[s.length >> 1] : 0; }

function ofDaemon(h) {
  const temperatures = (h.temperature_c ?? []).map((c, i) => `${h.temperature_name?.[i] ?? ""} ${c.toFixed(0)} °C`).join(", ");
  return row("state", h.state_text || h.state) + row("up", `${h.uptime_s?.toFixed(0)} s`) + row("frames in", `${h.grab_rate_hz?.toFixed(1)} Hz`) +
    row("poses out", `${h.pose_rate_hz?.toFixed(1)} Hz, ${(100 * (h.valid_share ?? 0)).toFixed(0)} % valid`) +
    row("latency", h.latency_p50_us > 0 ? `${ms(h.latency_p50_us)}, 99 % ${ms(h.latency_p99_us)}` : "") +
    row("dropped", `${h.frames_dropped} of ${h.frames_grabbed}`) + row("rejected", h.frames_rejected || "") + row("source errors", h.source_errors || "") +
    row("unsent", h.send_errors || "") + row("resets", h.resets || "") + row("memory", h.resident_bytes ? `${(h.resident_bytes / 1e6).toFixed(0)} MB` : "") +
    row("temperature", temperatures) + row("source", h.source_text) + row("recording", h.recording_text) + row("incidents", h.incident_text);
}

function ofRun(records, state) {
  const counted = new Map();
  for (const r of records.list) counted.set(r.s, (counted.get(r.s) ?? 0) + 1);
  const recent = records.list.slice(-300);
  return row("state", state.text) + row("frames", state.frames > 0 ? `${records.end} of ${state.frames}` : records.end) +
    row("failed", records.failed.length) + row("valid", counted.get(1) ?? 0) + row("a frame", recent.length ? `${median(recent.map(total)).toFixed(2)} ms, median` : "") +
    row("movers", records.list.at(-1)?.mv?.length ?? "");
}

export function healthHtml(records, state, live) {
  const h = state.health;
  let html = `<dl>${h ? ofDaemon(h) : ofRun(records, state)}</dl>`;
  if (state.error) html += `<p class="sentence warn">${escape(state.error)}</p>`;
  if (state.check) html += `<p class="sentence">${escape(state.check)}</p>`;
  if (state.view) html += `<p class="sentence warn">${escape(state.view)}</p>`;
  if (state.lost_pictures > 0) html += `<p class="sentence warn">${state.lost_pictures} pictures could not be kept: the disk is full</p>`;
  if (state.answer) html += `<p class="sentence dim">${escape(state.answer)}</p>`;
  if (live && !state.may_record) html += `<p class="sentence dim">Recording is the daemon's control socket's to start: see --socket.</p>`;
  return html;
}
