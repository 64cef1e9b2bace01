// SPDX-License-Identifier: BSD-3-Clause
// Now: the left image with what became of its features, disparity in colour, the right image beside it.
import { addMark, ramp, roles } from "./colours.js";
import { images, parts } from "./frame.js";

// Features as marks and lines from where they were; drawn in the image's own pixels times `scale`.
export function drawFeatures(context, features, scale) {
  const r = Math.max(2, 2.6 * Math.min(1.6, scale));
  context.lineWidth = 1.4;
  for (const k of [4, 5, 0, 1, 2, 3]) {
    const role = roles[k];
    context.strokeStyle = context.fillStyle = role.colour;
    context.globalAlpha = k === 4 ? 0.6 : 1;
    context.beginPath();  // one for all of a role: each costs
    for (const f of features) {
      if (f.role !== k) continue;
      if (k !== 4 && k !== 5) { context.moveTo(f.x * scale, f.y * scale); context.lineTo(f.fromX * scale, f.fromY * scale); }
      addMark(context, role.shape, f.x * scale, f.y * scale, r);
    }
    if (role.shape === "dot") context.fill(); else context.stroke();
  }
  context.globalAlpha = 1;
}

// width: of the image as it is drawn; the text stays within.
export function drawMovers(context, movers, scale, width) {
  context.font = "12px system-ui, sans-serif";
  for (const [id, ofVehicle, speed, distance, l, t, r, b] of movers ?? []) {
    const pad = 6;
    context.strokeStyle = roles[3].colour;
    context.lineWidth = 2;
    context.strokeRect(l * scale - pad, t * scale - pad, (r - l) * scale + 2 * pad, (b - t) * scale + 2 * pad);
    const text = ofVehicle ? `#${id} of the vehicle` : `#${id}  ${speed.toFixed(1)} m/s, ${distance.toFixed(1)} m away`;
    const w = context.measureText(text).width + 8;
    const y = t * scale - pad - 18 > 0 ? t * scale - pad - 18 : b * scale + pad;
    const x = Math.max(0, Math.min(l * scale - pad, width - w));
    context.fillStyle = "#000b";
    context.fillRect(x, y, w, 18);
    context.fillStyle = roles[3].colour;
    context.fillText(text, x + 4, y + 13);
  }
}

const absent = { right: "no right image is sent (lcm.images_right)", disparity: "no disparity is sent" };

// Where things are, at what size. Side by side rows are compared best: one below the other only where both get much larger so.
function layout(width, height, image, beside, scaleBar) {
  const room = width - (scaleBar ? 64 : 0);
  const fit = (columns, rows) => Math.min(room / (columns * image.width + (columns - 1) * 6), height / (rows * image.height + (rows - 1) * 6));
  const columns = beside && 1.5 * fit(2, 1) > fit(1, 2) ? 2 : 1;
  const rows = beside && columns === 1 ? 2 : 1;
  const scale = fit(columns, rows);
  const w = image.width * scale, h = image.height * scale;
  const x = (room - columns * w - (columns - 1) * 6) / 2, y = (height - rows * h - (rows - 1) * 6) / 2;
  return { scale, left: { x, y }, right: columns === 2 ? { x: x + w + 6, y } : { x, y: y + h + 6 }, w, h, columns };
}

export class PicturePanel {
  constructor(element, note, pointed) {
    this.canvas = element.querySelector("canvas");
    this.note = note;
    this.pointed = pointed;
    this.show = { features: true, disparity: false, right: false, mask: false };
    this.levels = document.createElement("canvas");
    new ResizeObserver(() => this.draw()).observe(element);
    this.canvas.addEventListener("pointermove", (event) => this.point(event));
    this.canvas.addEventListener("pointerleave", () => { this.pointed.textContent = ""; });
  }

  // wanted: which images were requested of it.
  set(picture, wanted, record, model) {
    if (this.picture?.disparity !== picture.disparity) this.coloured = null;
    this.close(picture);
    this.picture = picture;
    this.wanted = wanted;
    this.record = record;
    this.model = model;
    this.draw();
  }

  // Another source: nothing of this one is of use.
  clear() {
    this.close(null);
    this.picture = this.record = this.coloured = this.mask = null;
    this.draw();
  }

  close(next) {
    for (const k of ["left", "right", "disparity"]) {
      if (this.picture?.[k] && this.picture[k] !== next?.[k]) this.picture[k].close();
    }
  }

  images() { const { left, right, disparity } = this.picture; return { left, right, disparity }; }
  // The frame whose images are here, if those wanted are among them; else -1.
  has(wanted) { return this.picture?.left && (wanted & images & ~this.wanted) === 0 ? this.picture.pictured : -1; }

  get farthest() { return 254 * (this.picture?.step ?? 0.25); }

  // Levels of the disparity picture as colours, once a frame.
  colour() {
    if (this.coloured || !this.picture?.disparity) return this.coloured;
    const image = this.picture.disparity;
    this.levels.width = image.width;
    this.levels.height = image.height;
    const context = this.levels.getContext("2d", { willReadFrequently: true });
    context.drawImage(image, 0, 0);
    const pixels = context.getImageData(0, 0, image.width, image.height);
    const values = new Uint8Array(image.width * image.height);
    let most = 1;
    for (let i = 0; i < values.length; ++i) { values[i] = pixels.data[4 * i]; if (values[i] > most) most = values[i]; }
    const table = new Uint32Array(256);
    const top = Math.max(16, Math.min(255, most));
    for (let v = 1; v < 256; ++v) { const [r, g, b] = ramp[Math.min(255, Math.round(255 * v / top))]; table[v] = 0xff000000 | (b << 16) | (g << 8) | r; }
    const out = new Uint32Array(pixels.data.buffer);
    for (let i = 0; i < values.length; ++i) out[i] = table[values[i]];
    context.putImageData(pixels, 0, 0);
    this.coloured = { values, width: image.width, height: image.height, top };
    return this.coloured;
  }

  depth(disparity) { const m = this.model; return m && disparity + m.doffs > 0 ? (m.fx * m.baseline) / (disparity + m.doffs) : null; }

  draw() {
    const box = this.canvas.parentElement.getBoundingClientRect();
    const ratio = window.devicePixelRatio || 1;
    const width = Math.round(box.width * ratio), height = Math.round(box.height * ratio);
    if (width === 0 || height === 0) return;
    if (this.canvas.width !== width || this.canvas.height !== height) { this.canvas.width = width; this.canvas.height = height; }
    const context = this.canvas.getContext("2d");
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, box.width, box.height);
    const p = this.picture;
    const size = p?.left ?? (this.model && p?.features.length ? this.model : null);
    if (!size) { this.note.textContent = this.record ? "no picture of this frame" : "waiting for frames"; return; }
    const missing = ["right", "disparity"].filter((k) => this.show[k] && p.left && !p[k] && this.wanted & parts[k]);
    this.note.textContent = !p.left ? "no picture of this frame: features alone" : [p.pictured !== p.n ? `picture of ${p.n - p.pictured === 1 ? "the frame" : `${p.n - p.pictured} frames`} before` : "", ...missing.map((k) => absent[k])].filter(Boolean).join(" · ");
    const colours = this.show.disparity ? this.colour() : null;
    const beside = this.show.right && p.right;
    const l = (this.layout = layout(box.width, box.height, size, beside, colours));
    context.imageSmoothingEnabled = l.scale * ratio < 3;
    context.save();
    context.translate(l.left.x, l.left.y);
    context.beginPath(); context.rect(0, 0, l.w, l.h); context.clip();
    if (p.left) context.drawImage(p.left, 0, 0, l.w, l.h);
    if (colours) { context.globalAlpha = 0.75; context.drawImage(this.levels, 0, 0, l.w, l.h); context.globalAlpha = 1; }
    if (this.show.mask && this.mask) this.drawMask(context, l);
    if (this.show.features) { drawFeatures(context, p.features, l.scale); drawMovers(context, this.record?.mv, l.scale, l.w); }
    context.restore();
    if (beside) this.drawRight(context, l, p.right);
    if (colours) this.drawScale(context, box, colours);
  }

  drawMask(context, l) {
    context.globalAlpha = 0.55;
    context.globalCompositeOperation = "multiply";
    context.drawImage(this.mask, 0, 0, l.w, l.h);
    context.globalAlpha = 1;
    context.globalCompositeOperation = "source-over";
  }

  drawRight(context, l, right) {
    context.drawImage(right, l.right.x, l.right.y, l.w, l.h);
    if (this.show.features && this.picture) {
      context.save();
      context.translate(l.right.x, l.right.y);
      context.fillStyle = "#35e0a1";
      for (const f of this.picture.features) {
        if (f.role > 1) continue;
        context.fillRect((f.x - f.disparity) * l.scale - 1.5, f.y * l.scale - 1.5, 3, 3);
      }
      context.restore();
    }
    // The same rows in both, with their numbers.
    context.strokeStyle = "#ffffff66";
    context.fillStyle = "#ffffffcc";
    context.font = "10px system-ui, sans-serif";
    context.lineWidth = 1;
    context.beginPath();
    for (let k = 1; k < 12; ++k) {
      const row = Math.round((k * l.h) / l.scale / 12), y = Math.round(row * l.scale) + 0.5;
      for (const at of [l.left, l.right]) {
        context.moveTo(at.x, at.y + y); context.lineTo(at.x + l.w, at.y + y);
        if (l.h > 200) context.fillText(row, at.x + 3, at.y + y - 2);
      }
    }
    context.stroke();
  }

  // Colours with metres (or px where no model is known).
  drawScale(context, box, colours) {
    const x = box.width - 56, top = 24, height = box.height - 40;
    for (let k = 0; k < height; ++k) {
      const [r, g, b] = ramp[Math.round(255 * (1 - k / height))];
      context.fillStyle = `rgb(${r},${g},${b})`;
      context.fillRect(x, top + k, 12, 1.5);
    }
    context.fillStyle = "#dce3ea";
    context.font = "11px system-ui, sans-serif";
    context.fillText(this.model ? "m" : "px", x, 15);
    let before = -100;
    for (let k = 0; k <= 8; ++k) {
      const level = colours.top * (1 - k / 8), y = top + (k / 8) * height;
      const disparity = Math.max(level * this.picture.step, 0.25), z = this.depth(disparity);
      const text = z === null ? disparity.toFixed(1) : z < 10 ? z.toFixed(1) : z < 300 ? z.toFixed(0) : "∞";
      if (y - before < 14) continue;
      context.fillText(text, x + 16, Math.min(y + 4, box.height - 4));
      before = y;
    }
  }

  point(event) {
    const l = this.layout, p = this.picture;
    if (!l || !p) return;
    const box = this.canvas.getBoundingClientRect();
    const x = (event.clientX - box.left - l.left.x) / l.scale, y = (event.clientY - box.top - l.left.y) / l.scale;
    if (x < 0 || y < 0 || x >= l.w / l.scale || y >= l.h / l.scale) { this.pointed.textContent = ""; return; }
    let text = `(${x.toFixed(0)}, ${y.toFixed(0)})`;
    const c = this.show.disparity ? this.colour() : null;
    const v = c ? c.values[Math.floor(y) * c.width + Math.floor(x)] : 0;
    if (v > 0) { const d = v * p.step, z = this.depth(d); text += `  ${d.toFixed(1)} px` + (z ? `, ${z.toFixed(2)} m` : ""); }
    let best = null, least = 36;
    for (const f of p.features) { const d = (f.x - x) ** 2 + (f.y - y) ** 2; if (d < least) { least = d; best = f; } }
    if (best && this.show.features) {
      const z = this.depth(best.disparity);
      text = `${roles[best.role].name} (${best.x.toFixed(1)}, ${best.y.toFixed(1)})` + (z ? `, ${z.toFixed(2)} m` : "") + (best.role < 3 ? `, off by ${best.error.toFixed(2)} px` : "");
    }
    this.pointed.textContent = text;
  }
}
