// SPDX-License-Identifier: BSD-3-Clause
// A frame's pictures, as the server packs them (tools/view/store.cpp): a head of 64 bytes (magic, number, four sizes, step of the
// disparity levels, number of the frame that the pictures are of), then features, left image, right image, disparity.
export const parts = { features: 1, left: 2, right: 4, disparity: 8 };
export const images = parts.left | parts.right | parts.disparity;

export function unpack(buffer) {
  const head = new DataView(buffer);
  if (buffer.byteLength < 64 || head.getUint32(0) !== 0x43564631) return null;
  const out = { n: head.getUint32(4, true), step: head.getFloat32(24, true), pictured: head.getUint32(28, true), features: [] };
  let at = 64;
  const names = ["features", "left", "right", "disparity"];
  for (let k = 0; k < 4; ++k) {
    const size = head.getUint32(8 + 4 * k, true);
    if (k === 0) out.features = unpackFeatures(buffer, at, size);
    else out[names[k]] = size > 0 ? new Blob([new Uint8Array(buffer, at, size)], { type: k === 3 ? "image/png" : "image/jpeg" }) : null;
    at += size;
  }
  return out;
}

export function unpackFeatures(buffer, at, size) {
  const out = [];
  const view = new DataView(buffer);
  const f = (o) => view.getFloat32(o, true);
  for (let o = at; o + 28 <= at + size; o += 28) {
    out.push({ x: f(o), y: f(o + 4), fromX: f(o + 8), fromY: f(o + 12), disparity: f(o + 16), error: f(o + 20), role: view.getUint32(o + 24, true) });
  }
  return out;
}

const bitmap = (blob) => (blob ? createImageBitmap(blob).catch(() => null) : null);

// Images ready to be drawn; the browser decodes them beside the page's thread.
export async function decode(frame) {
  const [left, right, disparity] = await Promise.all([bitmap(frame.left), bitmap(frame.right), bitmap(frame.disparity)]);
  return { left, right, disparity };
}
