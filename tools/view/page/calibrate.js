// SPDX-License-Identifier: BSD-3-Clause
// The page of `cliquevo calibrate`: both images with the corners that were found, what is covered, what to do next.
import { Link } from "./link.js";
import { decode, parts, unpack } from "./frame.js";

const $ = (id) => document.getElementById(id);
const sides = ["left", "right"];
const page = { state: null, hello: null, drawn: 0 };
window.calibrate = page;  // for tests and the curious

const link = new Link(`ws://${location.host}/live`);
const over = () => page.state && (page.state.phase === "done" || page.state.phase === "failed");
function chip(text, kind) { $("connection").textContent = text; $("connection").className = `chip ${kind}`; }
link.addEventListener("open", () => chip("connected", "good"));
link.addEventListener("closed", () => chip(over() ? "ended" : "connecting again", over() ? "good" : "bad"));
link.addEventListener("hello", ({ detail }) => { page.hello = detail; $("source").textContent = detail.source; });
link.addEventListener("state", ({ detail }) => { page.state = detail; show(); });
link.addEventListener("frame", async ({ detail }) => {
  const frame = unpack(detail);
  if (!frame) return;
  const decoded = await decode(frame);
  sides.forEach((side, k) => draw(side, decoded[side], frame.features.filter((f) => f.role === k)));
  ++page.drawn;
});

const headlines = { solving: "calibrating", done: "done: the calibration is written", failed: "no calibration" };
function show() {
  const s = page.state;
  $("advice").textContent = s.phase === "looking" ? (s.text ? `${s.text}` : s.advice ?? $("advice").textContent) : `${headlines[s.phase]}${s.phase === "solving" ? `: ${s.text}` : ""}`;
  $("count").textContent = `${s.views ?? 0} views`;
  if (s.refusal === "taken") $("count").className = "chip good"; else $("count").className = "chip";
  if (over()) $("result").textContent = s.text;
  for (const id of ["take", "drop", "finish"]) $(id).disabled = s.phase !== "looking";
  $("estimate").textContent = s.estimate ? `so far: ${s.estimate}` : "";
  if (!s.bars) return;
  const speed = s.speed_px_s === null ? "" : `, moves ${s.speed_px_s.toFixed(0)} px/s`;
  const skew = s.skew_ms ? `, exposures ${s.skew_ms.toFixed(1)} ms apart` : "";
  $("facts-left").textContent = s.edge_px > 0 ? `edges ${s.edge_px.toFixed(1)} px wide${speed}${skew}` : "no board";
  const box = $("bars");
  if (box.children.length !== s.bars.length) {
    box.replaceChildren(...s.bars.map((bar) => {
      const goal = document.createElement("div");
      goal.className = "goal";
      goal.innerHTML = `<span></span><span class="meter"><b></b></span>`;
      goal.firstChild.textContent = bar.name;
      return goal;
    }));
  }
  s.bars.forEach((bar, k) => {
    const meter = box.children[k].querySelector(".meter");
    meter.className = `meter${bar.share >= 1 ? " full" : ""}`;
    meter.title = `${Math.round(100 * bar.share)} %`;
    meter.firstChild.style.width = `${100 * bar.share}%`;
  });
}

function draw(side, picture, corners) {
  const canvas = $(side);
  const [width, height] = page.state?.size ?? [0, 0];
  if (!picture || width === 0) return;
  if (canvas.width !== width || canvas.height !== height) { canvas.width = width; canvas.height = height; canvas.style.objectFit = "contain"; }
  const to = canvas.getContext("2d");
  to.drawImage(picture, 0, 0, width, height);
  const across = page.hello?.across ?? 8, cells = page.state[side] ?? [], down = Math.max(1, cells.length / across);
  to.fillStyle = "rgba(0, 158, 115, 0.25)";
  cells.forEach((cell, k) => { if (cell) to.fillRect((k % across) * width / across, Math.floor(k / across) * height / down, width / across, height / down); });
  to.strokeStyle = "#ffb000";
  to.lineWidth = Math.max(1, width / 400);
  for (const c of corners) { to.beginPath(); to.arc(c.x, c.y, 3 * to.lineWidth, 0, 2 * Math.PI); to.stroke(); }
}

function tick() {
  if (page.state && page.state.phase === "looking") link.request(-1, parts.features | parts.left | parts.right);
  setTimeout(() => requestAnimationFrame(tick), 60);
}
tick();

for (const [id, op] of [["take", "take-view"], ["drop", "drop-view"], ["finish", "finish"]]) $(id).onclick = () => link.command(op);
document.addEventListener("keydown", (event) => {
  if (event.key !== " " || event.target.tagName === "BUTTON") return;
  event.preventDefault();
  link.command("take-view");
});
