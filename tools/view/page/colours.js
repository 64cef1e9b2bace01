// SPDX-License-Identifier: BSD-3-Clause
// Colours that those who see no red or no green can distinguish (Okabe and Ito), and shapes that need no colour.
export const verdictColours = ["#8b98a5", "#1f9e77", "#e69f00", "#56b4e9", "#d55e00", "#cc79a7", "#f0e442"];

export const roles = [
  { name: "inlier", colour: "#35e0a1", shape: "disc" },
  { name: "of the key frame", colour: "#57c7ff", shape: "square" },
  { name: "outlier", colour: "#ff7a1a", shape: "cross" },
  { name: "mover", colour: "#ff8ad8", shape: "diamond" },
  { name: "not found", colour: "#c8ced4", shape: "dot" },
  { name: "corner", colour: "#f0e442", shape: "disc" },
];

// Turbo, which looks even and stays apart: by polynomials (A. Mikhailov, Apache-2.0).
function turbo(t) {
  const c = (a) => Math.max(0, Math.min(255, Math.round(255 * a.reduceRight((s, k) => s * t + k, 0))));
  return [
    c([0.13572138, 4.6153926, -42.66032258, 132.13108234, -152.94239396, 59.28637943]),
    c([0.09140261, 2.19418839, 4.84296658, -14.18503333, 4.27729857, 2.82956604]),
    c([0.1066733, 12.64194608, -60.58204836, 110.36276771, -89.90310912, 27.34824973]),
  ];
}
export const rainbow = Array.from({ length: 256 }, (_, i) => turbo(i / 255));

export function drawMark(context, shape, x, y, r) {
  context.beginPath();
  if (shape === "disc") context.arc(x, y, r, 0, 7);
  else if (shape === "square") context.rect(x - r, y - r, 2 * r, 2 * r);
  else if (shape === "diamond") { context.moveTo(x, y - r * 1.4); context.lineTo(x + r * 1.4, y); context.lineTo(x, y + r * 1.4); context.lineTo(x - r * 1.4, y); context.closePath(); }
  else if (shape === "dot") context.rect(x - r / 2, y - r / 2, r, r);
  else { context.moveTo(x - r, y - r); context.lineTo(x + r, y + r); context.moveTo(x - r, y + r); context.lineTo(x + r, y - r); }
  if (shape === "dot") context.fill(); else context.stroke();
}

export function markIcon(role) {
  const s = { disc: '<circle cx="6" cy="6" r="4"/>', square: '<rect x="2" y="2" width="8" height="8"/>', cross: '<path d="M2 2l8 8M2 10l8-8"/>', diamond: '<path d="M6 1l5 5-5 5-5-5z"/>', dot: '<rect x="4" y="4" width="3" height="3"/>' }[role.shape];
  return `<svg viewBox="0 0 12 12" fill="none" stroke="${role.colour}" stroke-width="1.6">${s}</svg>`;
}
