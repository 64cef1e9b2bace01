// SPDX-License-Identifier: BSD-3-Clause
// The page: what is shown is the frame `at`; everything follows it.
import { markIcon, roles, verdictColours } from "./colours.js";
import { decode, parts, unpack } from "./frame.js";
import { healthHtml } from "./health.js";
import { Link } from "./link.js";
import { PicturePanel } from "./picture.js";
import { isFailed, lengthText, Records } from "./record.js";
import { Charts, drawRibbon } from "./when.js";
import { ScenePanel } from "./where.js";
import { escape, whyHtml } from "./why.js";

const $ = (id) => document.getElementById(id);
const records = new Records();
const view = { at: -1, playing: true, follow: false, speed: 1, hello: null, state: {}, drawn: 0, received: 0, shown: -1, records };
window.cliquevo = view;  // for tests and the curious

const picture = new PicturePanel($("picture"), $("no-picture"), $("pointed"));
view.picture = picture;
const charts = new Charts($("charts"), (n) => seek(n));
let scene = null;
try {
  scene = new ScenePanel($("scene"), $("scene-legend"));
  scene.onFree = () => { scene.follow = $("follow-place").checked = false; };
} catch (error) {
  $("scene").innerHTML = `<div class="note">no 3-D here: ${escape(error.message)}</div>`;
}
$("roles").innerHTML = roles.map((r) => `<span>${markIcon(r)}${r.name}</span>`).join("");
$("scene-legend").innerHTML = '<span><i style="background:#ffb000"></i>way</span><span id="has-reference" hidden><i style="background:#e8eef4"></i>reference</span><span><i style="background:#cc79a7"></i>1σ</span><span id="up"></span><span>drag: turn · shift-drag: move · wheel: zoom</span>';

const link = new Link(`ws://${location.host}/live`);
Object.assign(view, { scene, seek });
link.addEventListener("open", () => chip("connected", "good"));
link.addEventListener("closed", () => chip("connecting again", "bad"));
link.addEventListener("hello", ({ detail }) => start(detail));
link.addEventListener("state", ({ detail }) => { view.state = detail; showHealth(); showUp(); });
link.addEventListener("mask", ({ detail }) => takeMask(detail.image));
link.addEventListener("records", ({ detail }) => take(detail));
link.addEventListener("frame", ({ detail }) => takeFrame(detail));

function chip(text, kind) { $("connection").textContent = text; $("connection").className = `chip ${kind}`; }

function start(hello) {
  view.hello = hello;
  records.clear();
  scene?.clear();
  Object.assign(view, { at: -1, shown: -1, playing: true, follow: hello.live });
  $("source").textContent = hello.source;
  $("feed").textContent = `${hello.live ? "live" : "recording"} · version ${hello.version}`;
  document.title = `${hello.source} - cliquevo view`;
  $("verdicts").innerHTML = hello.verdicts.map((name, k) => (k === 0 ? "" : `<span><i style="background:${verdictColours[k]}"></i>${escape(name)}</span>`)).join("");
  picture.clear();
  $("has-reference").hidden = true;
  $("show-mask").disabled = true;
}

function takeMask(source) {
  const image = new Image();
  image.onload = () => { picture.mask = image; $("show-mask").disabled = false; picture.draw(); };
  image.src = source;
}

// What "up" is: of the vehicle where it is known how the camera sits on it.
function showUp() {
  $("up").textContent = view.state.level ? "axes: the vehicle's" : "axes: the camera's at the start";
  $("up").title = view.state.level ? "X forward, Y left, Z up, where the vehicle started" : "How the camera sits on the vehicle is not known: where it looks down, the way climbs. body.roll_pitch_yaw_deg of the configuration tells it.";
}

function take({ first, records: added }) {
  const fresh = records.add(first, added);
  if (fresh.length === 0) return;
  if (fresh[0].tr || fresh.at(-1).tr) $("has-reference").hidden = false;
  scene?.add(fresh);
  stale = true;
  if (view.at < 0) seek(records.first, true);
  if (view.at < records.first) seek(records.first, true);
}

// Requests go out one at a time: a page that is slow skips frames.
function requestPicture() {
  if (view.at < 0 || link.busy || decoding || view.shown === key()) return;
  const wanted = parts.features | parts.left | (picture.show.right ? parts.right : 0) | (picture.show.disparity ? parts.disparity : 0);
  if (link.request(view.at, wanted, picture.has(wanted))) requested = { key: key(), parts: wanted };
}
const key = () => `${view.at}/${picture.show.right}/${picture.show.disparity}`;
let requested = null, decoding = false;

async function takeFrame(buffer) {
  ++view.received;
  const { key: shown, parts: wanted } = requested;
  const frame = unpack(buffer);
  if (!frame) return;
  const source = view.hello;
  decoding = true;
  const decoded = picture.has(wanted) === frame.pictured ? picture.images() : await decode(frame);
  decoding = false;
  if (source !== view.hello) return;  // of a view that has ended meanwhile
  view.shown = shown;
  picture.set({ ...frame, ...decoded }, wanted, records.get(frame.n), view.state.model);
  ++view.drawn;
  requestPicture();
}

function seek(n, keep = false) {
  n = Math.max(records.first, Math.min(records.end - 1, n));
  if (!(n >= 0)) return;
  if (!keep) { view.playing = false; view.follow = false; }
  view.at = n;
  clock = null;
  showFrame();
}

function showFrame() {
  const r = records.get(view.at);
  if (!r) return;
  scene?.set(r);
  charts.mark(r, false);
  placeCursor();
  textsDue = true;
  if (!view.playing) showTexts(performance.now());
  requestPicture();
}

// What is read rather than watched: while it plays, some times a second.
let textsDue = false, textsAt = 0;
function showTexts(now) {
  const r = records.get(view.at);
  if (!r) return;
  textsDue = false;
  textsAt = now;
  charts.mark(r);
  $("why").querySelector(".scroll").innerHTML = whyHtml(r, view.hello);
  const t = (r.t - records.list[0].t) / 1e6;
  $("position").textContent = `frame ${r.i}, ${t.toFixed(2)} s`;
  const off = r.tr ? `, ${lengthText(Math.hypot(r.p[0] - r.tr[0], r.p[1] - r.tr[1], r.p[2] - r.tr[2]))} off` : "";
  $("place").textContent = `${r.p[0].toFixed(2)} m forward, ${(-r.p[1]).toFixed(2)} right, ${r.p[2].toFixed(2)} up${off}`;
  $("place").title = `from the start, m${r.tr ? "; off: how far the way is from the reference" : ""}`;
  $("play").textContent = view.playing ? "❚❚" : "▶";
  $("next-failed").disabled = records.failed.length === 0;
}

// Where on the ribbon: of a recording all frames there will be, live what is kept.
const extent = () => ({ first: records.first, end: view.hello?.live ? records.end : Math.max(records.end, view.state.frames ?? 0) });
const cursor = document.createElement("div");
cursor.style.cssText = "position:absolute;top:0;bottom:0;width:3px;margin-left:-1px;background:#fff;box-shadow:0 0 0 1px #000;pointer-events:none;left:0";
$("ribbon").append(cursor);
let ribbonWidth = $("ribbon").clientWidth;
function placeCursor() {
  const e = extent();
  cursor.style.transform = `translateX(${((view.at + 0.5 - e.first) / Math.max(1, e.end - e.first)) * ribbonWidth}px)`;
}

let stale = true, chartsAt = 0, ribbonAt = 0;
function refresh(now) {
  if (!view.hello) return;
  if (stale && now - ribbonAt > 120) { ribbonAt = now; drawRibbon($("ribbon").querySelector("canvas"), records.list, extent()); placeCursor(); }
  if (stale && now - chartsAt > (records.list.length > 6000 ? 2000 : 600) && records.list.length > 0) {
    chartsAt = now;
    stale = false;
    charts.set(records.list, records.list[0].t);
    showHealth();
  }
}
function showHealth() {
  if (!view.hello) return;
  $("recording").hidden = !(view.hello.live && view.state.may_record);
  const box = $("health").querySelector(".scroll");
  const html = healthHtml(records, view.state, view.hello.live);
  if (box.dataset.html !== html) { box.innerHTML = html; box.dataset.html = html; }
}

// Playing: the frame that was due by now, at `speed` times the pace of the stamps.
let clock = null;
function advance(now) {
  if (view.follow) {
    if (records.end - 1 !== view.at) { view.at = records.end - 1; showFrame(); }
    return;
  }
  if (!view.playing || view.at < 0) { clock = null; return; }
  const r = records.get(view.at);
  if (!r) return;
  clock ??= { now, t: r.t };
  const due = clock.t + (now - clock.now) * 1000 * view.speed;
  let n = view.at;
  while (n + 1 < records.end) {
    const next = records.get(n + 1);
    if (next.ep !== r.ep || next.t < r.t || next.t - r.t > 2e6) { n += 1; clock = null; break; }  // a gap is not waited for
    if (next.t > due) break;
    n += 1;
  }
  if (n + 1 >= records.end) {
    clock = null;  // what comes later is played from there
    if (view.state.done && !view.hello.live) { view.playing = false; view.at = n; showFrame(); return; }
    if (view.hello.live) view.follow = true;
  }
  if (n !== view.at) { view.at = n; showFrame(); }
}

function tick(now) {
  advance(now);
  refresh(now);
  if (textsDue && now - textsAt > 120) showTexts(now);
  requestPicture();
  requestAnimationFrame(tick);
}
requestAnimationFrame(tick);

function play() {
  if (!view.playing && view.at >= records.end - 1 && !view.hello?.live) view.at = records.first;
  view.playing = !view.playing;
  view.follow = view.playing && view.hello?.live && view.at >= records.end - 2;
  clock = null;
  showFrame();
}
const step = (d) => seek(view.at + d);
function toEnd() { if (view.hello?.live) { view.playing = view.follow = true; } else seek(records.end - 1); }
function nextFailed() { const n = records.failed.find((k) => k > view.at) ?? records.failed[0]; if (n !== undefined) seek(n); }

for (const [id, action] of [["first", () => seek(records.first)], ["back", () => step(-1)], ["play", play], ["forth", () => step(1)], ["last", toEnd], ["next-failed", nextFailed]]) $(id).onclick = action;
$("speed").onchange = () => { view.speed = Number($("speed").value); clock = null; };
for (const name of ["features", "disparity", "right", "mask"]) {
  $(`show-${name}`).onchange = (event) => { picture.show[name] = event.target.checked; picture.draw(); requestPicture(); };
}
$("show-points").onchange = (event) => { if (scene) { scene.points.object.visible = event.target.checked; scene.render(); } };
$("follow-place").onchange = (event) => { if (scene) { scene.follow = event.target.checked; scene.render(); } };
$("above").onclick = () => scene?.above();
$("behind").onclick = () => scene?.behind();
$("health").addEventListener("click", (event) => { if (event.target.id.startsWith("record-")) link.command(event.target.id); });

const ribbon = $("ribbon");
function seekTo(event) {
  const box = ribbon.getBoundingClientRect(), e = extent();
  let n = e.first + Math.floor(((event.clientX - box.left) / box.width) * (e.end - e.first));
  // A failed frame may be narrower than a pixel: one that is near is meant.
  const near = Math.ceil((3 * (e.end - e.first)) / box.width);
  if (event.type === "pointerdown" && !(records.get(n) && isFailed(records.get(n)))) n = records.failed.find((k) => Math.abs(k - n) <= near) ?? n;
  seek(n);
}
ribbon.addEventListener("pointerdown", (event) => { ribbon.setPointerCapture(event.pointerId); seekTo(event); });
ribbon.addEventListener("pointermove", (event) => { if (event.buttons & 1) seekTo(event); });
new ResizeObserver(() => { ribbonWidth = ribbon.clientWidth; drawRibbon(ribbon.querySelector("canvas"), records.list, extent()); placeCursor(); }).observe(ribbon);

const toggle = (name) => { const box = $(`show-${name}`); if (!box.disabled) box.click(); };
const keys = { " ": play, ArrowLeft: () => step(-1), ArrowRight: () => step(1), PageUp: () => step(-30), PageDown: () => step(30), Home: () => seek(records.first), End: toEnd, n: nextFailed, f: () => toggle("features"), d: () => toggle("disparity"), r: () => toggle("right"), m: () => toggle("mask"), a: () => scene?.above(), b: () => scene?.behind() };
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || event.target.tagName === "SELECT") return;
  const action = keys[event.key] ?? keys[event.key.toLowerCase()];
  if (!action) return;
  event.preventDefault();
  if (event.target.tagName === "BUTTON" || event.target.tagName === "INPUT") event.target.blur();
  action();
});
