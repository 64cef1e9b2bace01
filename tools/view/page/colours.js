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

// Plasma of matplotlib, by polynomials (M. Zucker, public domain): the brighter the nearer, also without colours.
function plasma(t) {
  const c = (a) => Math.max(0, Math.min(255, Math.round(255 * a.reduceRight((s, k) => s * t + k, 0))));
  return [
    c([0.05873234392399702, 2.176514634195958, -2.689460476458034, 6.130348345893603, -11.10743619062271, 10.02306557647065, -3.658713842777788]),
    c([0.02333670892565664, 0.2383834171260182, -7.455851135738909, 42.3461881477227, -82.66631109428045, 71.41361770095349, -22.93153465461149]),
    c([0.5433401826748754, 0.7539604599784036, 3.110799939717086, -28.51885465332158, 60.13984767418263, -54.07218655560067, 18.19190778539828]),
  ];
}
export const ramp = Array.from({ length: 256 }, (_, i) => plasma(i / 255));

// Adds a mark to the path; those of shape "dot" are to be filled, the others stroked.
export function addMark(context, shape, x, y, r) {
  if (shape === "disc") { context.moveTo(x + r, y); context.arc(x, y, r, 0, 7); }
  else if (shape === "square") context.rect(x - r, y - r, 2 * r, 2 * r);
  else if (shape === "diamond") { context.moveTo(x, y - r * 1.4); context.lineTo(x + r * 1.4, y); context.lineTo(x, y + r * 1.4); context.lineTo(x - r * 1.4, y); context.closePath(); }
  else if (shape === "dot") context.rect(x - r / 2, y - r / 2, r, r);
  else { context.moveTo(x - r, y - r); context.lineTo(x + r, y + r); context.moveTo(x - r, y + r); context.lineTo(x + r, y - r); }
}

export function markIcon(role) {
  const s = { disc: '<circle cx="6" cy="6" r="4"/>', square: '<rect x="2" y="2" width="8" height="8"/>', cross: '<path d="M2 2l8 8M2 10l8-8"/>', diamond: '<path d="M6 1l5 5-5 5-5-5z"/>', dot: '<rect x="4" y="4" width="3" height="3"/>' }[role.shape];
  return `<svg viewBox="0 0 12 12" fill="none" stroke="${role.colour}" stroke-width="1.6">${s}</svg>`;
}
