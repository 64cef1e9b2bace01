// SPDX-License-Identifier: BSD-3-Clause
// A frame's record, as the server writes it (tools/view/facts.cpp):
//   n number in the view, i index in its source, t stamp (us), ep epoch, s verdict, q quality
//   p place (m: forward, left, up), o turn (w x y z), cv covariance of the place (xx yy zz xy xz yz, m^2)
//   c [features, matches, clique, inliers], sg sigma of the step (m), e and ee reprojection error and what is expected (px)
//   sh common disparity error (px), sc [disparity offset, sigma, vertical, sigma] (px)
//   fm mask of failed checks, ck [[ratio, value, bound], ...], tm [rectify, stereo, odometry] (us), st steps (us)
//   lt latency (us), tr true place (m), mv movers [[id, of the vehicle, speed, distance, left, top, right, bottom], ...]
//   pt points of features [x, y, z, ...] (m)
export class Records {
  constructor() { this.first = 0; this.list = []; this.failed = []; }
  get end() { return this.first + this.list.length; }
  get(n) { return this.list[n - this.first]; }
  add(first, records) {
    const grown = [];
    for (const r of records) {
      if (r.n < this.end) continue;
      if (r.n > this.end) { this.list = []; this.first = r.n; this.failed = []; }  // a gap: what lay between is gone
      this.list.push(r);
      if (isFailed(r)) this.failed.push(r.n);
      grown.push(r);
    }
    if (first > this.first) {
      this.list.splice(0, first - this.first);
      this.first = first;
      while (this.failed.length && this.failed[0] < first) this.failed.shift();
    }
    return grown;
  }
  clear() { this.first = 0; this.list = []; this.failed = []; }
}

// The first frame of all has nothing to be compared with: no failure.
export const isFailed = (r) => r.s !== 1 && r.s !== 0;
export const isValid = (r) => r.s === 1;
export const sigmaOfPlace = (r) => Math.sqrt(Math.max(0, r.cv[0] + r.cv[1] + r.cv[2]));
export const total = (r) => (r.tm[0] + r.tm[1] + r.tm[2]) / 1000;

export function lengthText(m) { return Math.abs(m) >= 1000 ? (m / 1000).toFixed(2) + " km" : Math.abs(m) >= 0.1 || m === 0 ? m.toFixed(2) + " m" : (1000 * m).toFixed(1) + " mm"; }
