// SPDX-License-Identifier: BSD-3-Clause
// The normal equations of step A5, four observations at a time. One formula for every instruction set: V is a pack of
// four doubles, either the plain struct below (the reference) or the compiler's vector type; the order of every sum is
// the same, and so is every bit. Internal linkage on purpose: each kernel file is compiled with other machine options.
#pragma once

#include "core/vo/kernels/kernels.h"

namespace cliquevo::vo {
namespace {

// Comparisons: select_less(a, b, x, y) is a < b ? x : y in each lane.
struct PlainPack {
  double lane[kMotionLanes];
};

#define CLIQUEVO_PLAIN_OPERATOR(op)                                            \
  inline PlainPack operator op(PlainPack a, PlainPack b) {                     \
    for (int i = 0; i < kMotionLanes; ++i) a.lane[i] = a.lane[i] op b.lane[i]; \
    return a;                                                                  \
  }
CLIQUEVO_PLAIN_OPERATOR(+)
CLIQUEVO_PLAIN_OPERATOR(-)
CLIQUEVO_PLAIN_OPERATOR(*)
CLIQUEVO_PLAIN_OPERATOR(/)
#undef CLIQUEVO_PLAIN_OPERATOR

// The compiler's vectors: one of four lanes where a register holds that, else two of two.
#if defined(__AVX2__)
using VectorPack = double __attribute__((vector_size(32)));
inline double lane_of(const VectorPack& p, int i) { return p[i]; }
inline void set_lane(VectorPack& p, int i, double v) { p[i] = v; }
inline VectorPack select_less(VectorPack a, VectorPack b, VectorPack x, VectorPack y) { return a < b ? x : y; }
#else
using HalfPack = double __attribute__((vector_size(16)));
struct VectorPack {
  HalfPack half[2];
};
#define CLIQUEVO_HALVES_OPERATOR(op)                           \
  inline VectorPack operator op(VectorPack a, VectorPack b) {  \
    return {{a.half[0] op b.half[0], a.half[1] op b.half[1]}}; \
  }
CLIQUEVO_HALVES_OPERATOR(+)
CLIQUEVO_HALVES_OPERATOR(-)
CLIQUEVO_HALVES_OPERATOR(*)
CLIQUEVO_HALVES_OPERATOR(/)
#undef CLIQUEVO_HALVES_OPERATOR
inline double lane_of(const VectorPack& p, int i) { return p.half[i / 2][i % 2]; }
inline void set_lane(VectorPack& p, int i, double v) { p.half[i / 2][i % 2] = v; }
inline VectorPack select_less(VectorPack a, VectorPack b, VectorPack x, VectorPack y) {
  return {{a.half[0] < b.half[0] ? x.half[0] : y.half[0], a.half[1] < b.half[1] ? x.half[1] : y.half[1]}};
}
#endif
inline double lane_of(const PlainPack& p, int i) { return p.lane[i]; }
inline void set_lane(PlainPack& p, int i, double v) { p.lane[i] = v; }
inline PlainPack select_less(PlainPack a, PlainPack b, PlainPack x, PlainPack y) {
  for (int i = 0; i < kMotionLanes; ++i) x.lane[i] = a.lane[i] < b.lane[i] ? x.lane[i] : y.lane[i];
  return x;
}

template <class V>
inline V load(const double* from) {
  V out;
  __builtin_memcpy(&out, from, sizeof out);
  return out;
}
template <class V>
inline V all(double v) {
  V out;
  for (int i = 0; i < kMotionLanes; ++i) set_lane(out, i, v);
  return out;
}
template <class V>
inline V square_root(V v) {
  for (int i = 0; i < kMotionLanes; ++i) set_lane(v, i, __builtin_sqrt(lane_of(v, i)));
  return v;
}
template <class V>
inline double sum_lanes(V v) {
  return (lane_of(v, 0) + lane_of(v, 2)) + (lane_of(v, 1) + lane_of(v, 3));
}

// One way's weighted residual: the projection of `y` against the observation, with the Jacobian rows of y's change.
template <class V>
struct OneWay {
  V e[3], j[3], we[3], wj[3];  // residual; its change with the other frame's disparity; both weighted
  V J[3][3];                   // projection Jacobian
  V s;                         // W = diag(w) - s (w j)(w j)^T
  V squared;                   // e^T W e
};

template <class V>
inline void one_way(const MotionState& c, const V* y, const V* k, const V* observed, OneWay<V>& o) {
  const V zero = all<V>(0.0);
  const V iz = all<V>(1.0) / y[2];
  const V a = all<V>(c.fx) * iz;
  const V b = all<V>(c.fy) * iz;
  const V xz = y[0] * iz;
  const V yz = y[1] * iz;
  const V fbz = all<V>(c.fx_baseline) * iz;
  o.e[0] = observed[0] - (all<V>(c.fx) * xz + all<V>(c.cx));
  o.e[1] = observed[1] - (all<V>(c.fy) * yz + all<V>(c.cy));
  o.e[2] = observed[2] - (fbz - all<V>(c.doffs));
  o.J[0][0] = a, o.J[0][1] = zero, o.J[0][2] = zero - a * xz;
  o.J[1][0] = zero, o.J[1][1] = b, o.J[1][2] = zero - b * yz;
  o.J[2][0] = zero, o.J[2][1] = zero, o.J[2][2] = zero - fbz * iz;
  o.j[0] = a * (k[0] - xz * k[2]);
  o.j[1] = b * (k[1] - yz * k[2]);
  o.j[2] = o.J[2][2] * k[2];
  const V wp = all<V>(c.weight_px);
  const V wd = all<V>(c.weight_d);
  const V w[3] = {wp, wp, wd};
  V jwj = zero;
  V jwe = zero;
  for (int i = 0; i < 3; ++i) {
    o.wj[i] = w[i] * o.j[i];
    o.we[i] = w[i] * o.e[i];
    jwj = jwj + o.j[i] * o.wj[i];
    jwe = jwe + o.j[i] * o.we[i];
  }
  const V variance = all<V>(c.variance_d);
  o.s = variance / (all<V>(1.0) + variance * jwj);
  o.squared = zero;
  for (int i = 0; i < 3; ++i) {
    o.we[i] = o.we[i] - o.s * o.wj[i] * jwe;
    o.squared = o.squared + o.e[i] * o.we[i];
  }
}

// Adds weight * (A^T W A, A^T W e) and the same for the disparity offset.
template <class V>
inline void add_way(const MotionState& c, const OneWay<V>& o, const V (&A)[3][6], V weight, V (&H)[21], V (&g)[6],
                    V (&h)[6], V& hh, V& og) {
  const V wp = all<V>(c.weight_px) * weight;
  const V wd = all<V>(c.weight_d) * weight;
  const V w[3] = {wp, wp, wd};
  const V s = o.s * weight;
  V we[3];
  V wa[3];
  V jwa = all<V>(0.0);
  const V one = all<V>(1.0);
  const V a[3] = {all<V>(0.0) - o.j[0], all<V>(0.0) - o.j[1], one - o.j[2]};
  for (int i = 0; i < 3; ++i) jwa = jwa + o.wj[i] * a[i];
  for (int i = 0; i < 3; ++i) {
    we[i] = o.we[i] * weight;
    wa[i] = w[i] * a[i] - s * o.wj[i] * jwa;
    hh = hh + a[i] * wa[i];
    og = og + o.e[i] * wa[i];
  }
  V WA[3][6];
  V q[6];
  for (int k = 0; k < 6; ++k) {
    q[k] = o.wj[0] * A[0][k] + o.wj[1] * A[1][k] + o.wj[2] * A[2][k];
    for (int i = 0; i < 3; ++i) WA[i][k] = w[i] * A[i][k];
    g[k] = g[k] + (A[0][k] * we[0] + A[1][k] * we[1] + A[2][k] * we[2]);
    h[k] = h[k] + (A[0][k] * wa[0] + A[1][k] * wa[1] + A[2][k] * wa[2]);
  }
  int n = 0;
  for (int r = 0; r < 6; ++r) {
    const V sq = s * q[r];
    for (int k = r; k < 6; ++k, ++n) {
      H[n] = H[n] + ((A[0][r] * WA[0][k] + A[1][r] * WA[1][k]) + (A[2][r] * WA[2][k] - sq * q[k]));
    }
  }
}

template <class V>
void motion_sums_of(const MotionTerms& terms, const MotionState& c, MotionSums& out) {
  const V zero = all<V>(0.0);
  V H[21], g[6], h[6];
  for (V& v : H) v = zero;
  for (V& v : g) v = zero;
  for (V& v : h) v = zero;
  V hh = zero, og = zero, cost = zero;
  const V near = all<V>(c.min_depth);
  const V one = all<V>(1.0);
  const V half = all<V>(0.5);
  const V huber = all<V>(c.huber);
  for (int i = 0; i < terms.count; i += kMotionLanes) {
    const auto field = [&](int f) { return load<V>(terms.field[f] + i); };
    const V q[3] = {field(kQx), field(kQy), field(kQz)};
    const V dq[3] = {field(kDx), field(kDy), field(kDz)};
    const V p[3] = {field(kPx), field(kPy), field(kPz)};
    const V cur[3] = {field(kCurU), field(kCurV), field(kCurD)};
    const V ref[3] = {field(kRefU), field(kRefV), field(kRefD)};
    const V active = field(kActive);
    V y[3], k[3], z[3], l[3];
    const V d[3] = {q[0] - all<V>(c.t[0]), q[1] - all<V>(c.t[1]), q[2] - all<V>(c.t[2])};
    const V inverse_d = field(kInverseD);
    for (int r = 0; r < 3; ++r) {
      const V r0 = all<V>(c.R[0][r]), r1 = all<V>(c.R[1][r]), r2 = all<V>(c.R[2][r]);
      y[r] = r0 * d[0] + r1 * d[1] + r2 * d[2];
      k[r] = r0 * dq[0] + r1 * dq[1] + r2 * dq[2];
      const V m0 = all<V>(c.M[r][0]), m1 = all<V>(c.M[r][1]), m2 = all<V>(c.M[r][2]);
      const V turned = m0 * p[0] + m1 * p[1] + m2 * p[2];
      z[r] = turned + all<V>(c.m[r]);
      l[r] = zero - turned * inverse_d;
    }
    // At or behind the camera nothing can be judged: no weight, and an error that nobody trusts.
    V good = select_less(near, y[2], active, zero);
    good = select_less(near, z[2], good, zero);
    const V behind = all<V>(kBehindCamera);
    V squared_if = select_less(near, y[2], zero, behind);
    squared_if = select_less(near, z[2], squared_if, behind);
    y[2] = select_less(near, y[2], y[2], one);
    z[2] = select_less(near, z[2], z[2], one);
    OneWay<V> to_cur, to_ref;
    one_way(c, y, k, cur, to_cur);
    one_way(c, z, l, ref, to_ref);
    const V squared = half * (to_cur.squared + to_ref.squared) + squared_if;
    __builtin_memcpy(terms.field[kSquared] + i, &squared, sizeof squared);
    const V sigmas = square_root(squared);
    const V weight = half * good * select_less(huber, sigmas, huber / sigmas, one);
    cost = cost + active * select_less(huber, sigmas, huber * (sigmas + sigmas - huber), squared);
    V A[3][6];
    for (int r = 0; r < 3; ++r) {  // change of y with a perturbation of T on the right: [-1 | [y]x]
      const V* J = to_cur.J[r];
      for (int n = 0; n < 3; ++n) A[r][n] = zero - J[n];
      A[r][3] = J[1] * y[2] - J[2] * y[1];
      A[r][4] = J[2] * y[0] - J[0] * y[2];
      A[r][5] = J[0] * y[1] - J[1] * y[0];
    }
    add_way(c, to_cur, A, weight, H, g, h, hh, og);
    for (int r = 0; r < 3; ++r) {  // of z: M [1 | -[p]x]
      const V* J = to_ref.J[r];
      V N[3];
      for (int n = 0; n < 3; ++n) {
        N[n] = J[0] * all<V>(c.M[0][n]) + J[1] * all<V>(c.M[1][n]) + J[2] * all<V>(c.M[2][n]);
        A[r][n] = N[n];
      }
      A[r][3] = N[2] * p[1] - N[1] * p[2];
      A[r][4] = N[0] * p[2] - N[2] * p[0];
      A[r][5] = N[1] * p[0] - N[0] * p[1];
    }
    add_way(c, to_ref, A, weight, H, g, h, hh, og);
  }
  for (int i = 0; i < 21; ++i) out.H[i] += sum_lanes(H[i]);
  for (int i = 0; i < 6; ++i) out.g[i] += sum_lanes(g[i]);
  for (int i = 0; i < 6; ++i) out.offset_h[i] += sum_lanes(h[i]);
  out.offset_hh += sum_lanes(hh);
  out.offset_g += sum_lanes(og);
  out.cost += sum_lanes(cost);
}

}  // namespace
}  // namespace cliquevo::vo
