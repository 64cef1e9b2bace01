// SPDX-License-Identifier: BSD-3-Clause
// The normal equations of step A5, four observations at a time. One formula for every instruction set: V is a pack of
// four doubles, either the plain struct below (the reference) or the compiler's vector type; the order of every sum is
// the same, and so is every bit. Internal linkage on purpose: each kernel file is compiled with other machine options.
#pragma once

#include "core/vo/kernels/intrinsics.h"
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
inline PlainPack square_root(PlainPack v) {
  for (double& lane : v.lane) lane = __builtin_sqrt(lane);
  return v;
}
#if defined(__AVX2__)
inline VectorPack square_root(VectorPack v) { return _mm256_sqrt_pd(v); }
#elif defined(__SSE2__)
inline VectorPack square_root(VectorPack v) { return {{_mm_sqrt_pd(v.half[0]), _mm_sqrt_pd(v.half[1])}}; }
#elif defined(__aarch64__)
inline VectorPack square_root(VectorPack v) { return {{vsqrtq_f64(v.half[0]), vsqrtq_f64(v.half[1])}}; }
#else
inline VectorPack square_root(VectorPack v) {
  for (int i = 0; i < kMotionLanes; ++i) set_lane(v, i, __builtin_sqrt(lane_of(v, i)));
  return v;
}
#endif
template <class V>
inline double sum_lanes(V v) {
  return (lane_of(v, 0) + lane_of(v, 2)) + (lane_of(v, 1) + lane_of(v, 3));
}

// One way's weighted residual: the projection of a point against the observation. Its Jacobian's rows are (a, 0, -a x),
// (0, b, -b y) and (0, 0, -c), with x, y the point's directions.
template <class V>
struct OneWay {
  V e[3], j[3], we[3], wj[3];  // residual; its change with the other frame's disparity; both weighted
  V a, ax, b, by, c;           // the projection's Jacobian
  V jwj, s;                    // W = diag(w) - s (w j)(w j)^T
  V squared;                   // e^T W e
};

template <class V>
[[gnu::always_inline]] inline void one_way(const MotionState& c, const V* y, const V* k, const V* observed,
                                           OneWay<V>& o) {
  const V zero = all<V>(0.0);
  const V iz = all<V>(1.0) / y[2];
  const V xz = y[0] * iz;
  const V yz = y[1] * iz;
  const V fbz = all<V>(c.fx_baseline) * iz;
  o.e[0] = observed[0] - (all<V>(c.fx) * xz + all<V>(c.cx));
  o.e[1] = observed[1] - (all<V>(c.fy) * yz + all<V>(c.cy));
  o.e[2] = observed[2] - (fbz - all<V>(c.doffs));
  o.a = all<V>(c.fx) * iz;
  o.b = all<V>(c.fy) * iz;
  o.c = fbz * iz;
  o.ax = o.a * xz;
  o.by = o.b * yz;
  o.j[0] = o.a * (k[0] - xz * k[2]);
  o.j[1] = o.b * (k[1] - yz * k[2]);
  o.j[2] = zero - o.c * k[2];
  const V wp = all<V>(c.weight_px);
  const V wd = all<V>(c.weight_d);
  const V w[3] = {wp, wp, wd};
  o.jwj = zero;
  V jwe = zero;
  for (int i = 0; i < 3; ++i) {
    o.wj[i] = w[i] * o.j[i];
    o.we[i] = w[i] * o.e[i];
    o.jwj = o.jwj + o.j[i] * o.wj[i];
    jwe = jwe + o.j[i] * o.we[i];
  }
  const V variance = all<V>(c.variance_d);
  o.s = variance / (all<V>(1.0) + variance * o.jwj);
  o.squared = zero;
  const V sjwe = o.s * jwe;
  for (int i = 0; i < 3; ++i) {
    o.we[i] = o.we[i] - o.wj[i] * sjwe;
    o.squared = o.squared + o.e[i] * o.we[i];
  }
}

// One way's sums, of a perturbation (r, w) of the projected point y: dy = r + w x y. H: upper triangle, row by row.
// The errors of the disparities enter in two places: the observed disparity's directly (e3 = (0, 0, 1)), and the
// projected point's through its Jacobian j. Every sum that the solver needs is one of these two or their difference.
template <class V>
struct WaySums {
  V H[21], g[6];
  V direct[6], through[6];  // A^T W e3, A^T W j
  V dd, dj, jj;             // e3^T W e3, e3^T W j, j^T W j
  V de, je;                 // e3^T W e, j^T W e
  WaySums() {
    for (V& v : H) v = all<V>(0.0);
    for (int i = 0; i < 6; ++i) g[i] = direct[i] = through[i] = all<V>(0.0);
    dd = dj = jj = de = je = all<V>(0.0);
  }
};

template <class V>
inline void cross(const V* v, const V* y, V* out) {
  out[0] = v[1] * y[2] - v[2] * y[1];
  out[1] = v[2] * y[0] - v[0] * y[2];
  out[2] = v[0] * y[1] - v[1] * y[0];
}

// Adds weight * (A^T W A, A^T W e) and the same for the disparities' errors; A = J D, where D v = r + w x y.
template <class V>
[[gnu::always_inline]] inline void add_way(const MotionState& c, const OneWay<V>& o, const V* y, V weight,
                                           WaySums<V>& sums) {
  const V zero = all<V>(0.0);
  const V wp = all<V>(c.weight_px) * weight;
  const V wd = all<V>(c.weight_d) * weight;
  const V s = o.s * weight;
  // J^T times a vector.
  const auto back = [&](V v0, V v1, V v2, V(&out)[3]) {
    out[0] = o.a * v0;
    out[1] = o.b * v1;
    out[2] = zero - (o.ax * v0 + o.by * v1 + o.c * v2);
  };
  V q[3], gy[3], turned[3];
  back(o.wj[0], o.wj[1], o.wj[2], q);
  back(o.we[0] * weight, o.we[1] * weight, o.we[2] * weight, gy);
  // B = J^T W J
  const V sq[3] = {s * q[0], s * q[1], s * q[2]};
  const V wa0 = wp * o.a, wb1 = wp * o.b, wax = wp * o.ax, wby = wp * o.by, wdc = wd * o.c;
  V B[3][3];
  B[0][0] = wa0 * o.a - sq[0] * q[0];
  B[0][1] = zero - sq[0] * q[1];
  B[0][2] = zero - (wa0 * o.ax + sq[0] * q[2]);
  B[1][1] = wb1 * o.b - sq[1] * q[1];
  B[1][2] = zero - (wb1 * o.by + sq[1] * q[2]);
  B[2][2] = (wax * o.ax + wby * o.by) + (wdc * o.c - sq[2] * q[2]);
  B[1][0] = B[0][1], B[2][0] = B[0][2], B[2][1] = B[1][2];
  // A vector v of the point becomes (v, y x v) of the perturbation.
  V* const H = sums.H;
  H[0] = H[0] + B[0][0], H[1] = H[1] + B[0][1], H[2] = H[2] + B[0][2];
  H[6] = H[6] + B[1][1], H[7] = H[7] + B[1][2], H[11] = H[11] + B[2][2];
  V E[3][3];  // row i: y x B_i
  for (int i = 0; i < 3; ++i) cross(y, B[i], E[i]);
  for (int i = 0; i < 3; ++i) H[3 + i] = H[3 + i] + E[0][i];
  for (int i = 0; i < 3; ++i) H[8 + i] = H[8 + i] + E[1][i];
  for (int i = 0; i < 3; ++i) H[12 + i] = H[12 + i] + E[2][i];
  H[15] = H[15] + (y[1] * E[2][0] - y[2] * E[1][0]);
  H[16] = H[16] + (y[1] * E[2][1] - y[2] * E[1][1]);
  H[17] = H[17] + (y[1] * E[2][2] - y[2] * E[1][2]);
  H[18] = H[18] + (y[2] * E[0][1] - y[0] * E[2][1]);
  H[19] = H[19] + (y[2] * E[0][2] - y[0] * E[2][2]);
  H[20] = H[20] + (y[0] * E[1][2] - y[1] * E[0][2]);
  cross(y, gy, turned);
  for (int i = 0; i < 3; ++i) {
    sums.g[i] = sums.g[i] + gy[i];
    sums.g[3 + i] = sums.g[3 + i] + turned[i];
  }
  // W j is w j shortened; W e3 is (0, 0, wd) less its share along w j.
  const V shortened = weight - s * o.jwj;
  const V along = s * o.wj[2];
  const V across[3] = {wdc * y[1], wdc * y[0], wdc};  // of J^T (0, 0, wd), without signs
  cross(y, q, turned);
  for (int i = 0; i < 3; ++i) {
    sums.through[i] = sums.through[i] + shortened * q[i];
    sums.through[3 + i] = sums.through[3 + i] + shortened * turned[i];
  }
  sums.direct[0] = sums.direct[0] - along * q[0];
  sums.direct[1] = sums.direct[1] - along * q[1];
  sums.direct[2] = sums.direct[2] - (across[2] + along * q[2]);
  sums.direct[3] = sums.direct[3] - (across[0] + along * turned[0]);
  sums.direct[4] = sums.direct[4] + (across[1] - along * turned[1]);
  sums.direct[5] = sums.direct[5] - along * turned[2];
  sums.dd = sums.dd + (wd - along * o.wj[2]);
  sums.dj = sums.dj + shortened * o.wj[2];
  sums.jj = sums.jj + shortened * o.jwj;
  sums.de = sums.de + o.we[2] * weight;
  sums.je = sums.je + (o.j[0] * o.we[0] + o.j[1] * o.we[1] + o.j[2] * o.we[2]) * weight;
}

// Adds the sums of a perturbation v to those of u, where v = F u; F is 6 x 6.
inline void add_transformed(const double (&F)[6][6], const double (&H)[21], const double (&g)[6], const double (&h)[6],
                            const double (&s)[6], MotionSums& out) {
  double full[6][6], HF[6][6];
  int n = 0;
  for (int r = 0; r < 6; ++r) {
    for (int k = r; k < 6; ++k) full[r][k] = full[k][r] = H[n++];
  }
  for (int r = 0; r < 6; ++r) {
    for (int k = 0; k < 6; ++k) {
      HF[r][k] = 0.0;
      for (int i = 0; i < 6; ++i) HF[r][k] += full[r][i] * F[i][k];
    }
  }
  n = 0;
  for (int r = 0; r < 6; ++r) {
    for (int k = r; k < 6; ++k, ++n) {
      for (int i = 0; i < 6; ++i) out.H[n] += F[i][r] * HF[i][k];
    }
    for (int i = 0; i < 6; ++i) {
      out.g[r] += F[i][r] * g[i];
      out.offset_h[r] += F[i][r] * h[i];
      out.shift_h[r] += F[i][r] * s[i];
    }
  }
}

// The common error of all disparities is what is observed less what it moves the projected points by; the current
// frame's own is observed on the one way, and moves the projected points on the other.
enum class Way { to_current, to_reference };

template <Way kWay, class V>
inline void add_sums(const double (&F)[6][6], const WaySums<V>& sums, MotionSums& out) {
  double H[21], g[6], h[6], s[6];
  for (int i = 0; i < 21; ++i) H[i] = sum_lanes(sums.H[i]);
  for (int i = 0; i < 6; ++i) {
    g[i] = sum_lanes(sums.g[i]);
    const double direct = sum_lanes(sums.direct[i]);
    const double through = sum_lanes(sums.through[i]);
    h[i] = direct - through;
    s[i] = kWay == Way::to_current ? direct : -through;
  }
  add_transformed(F, H, g, h, s, out);
  const double dd = sum_lanes(sums.dd), dj = sum_lanes(sums.dj), jj = sum_lanes(sums.jj);
  const double de = sum_lanes(sums.de), je = sum_lanes(sums.je);
  out.offset_hh += dd - 2.0 * dj + jj;
  out.offset_g += de - je;
  out.shift_hh += kWay == Way::to_current ? dd : jj;
  out.shift_g += kWay == Way::to_current ? de : -je;
  out.shift_offset += kWay == Way::to_current ? dd - dj : jj - dj;
}

template <class V>
void motion_sums_of(const MotionTerms& terms, const MotionState& c, MotionSums& out) {
  const V zero = all<V>(0.0);
  WaySums<V> of_cur, of_ref;
  V cost = zero;
  const V shift = all<V>(c.shift);
  const V near = all<V>(c.min_depth);
  const V one = all<V>(1.0);
  const V half = all<V>(0.5);
  const V huber = all<V>(c.huber);
  for (int i = 0; i < terms.count; i += kMotionLanes) {
    const auto field = [&](int f) { return load<V>(terms.field[f] + i); };
    const V q[3] = {field(kQx), field(kQy), field(kQz)};
    const V dq[3] = {field(kDx), field(kDy), field(kDz)};
    // The current frame's disparities without their common error: its points move along their rays.
    const V farther = one / (one - shift * field(kInverseD));
    const V p[3] = {field(kPx) * farther, field(kPy) * farther, field(kPz) * farther};
    const V cur[3] = {field(kCurU), field(kCurV), field(kCurD) - shift};
    const V ref[3] = {field(kRefU), field(kRefV), field(kRefD)};
    const V active = field(kActive);
    V y[3], k[3], z[3], l[3];
    const V d[3] = {q[0] - all<V>(c.t[0]), q[1] - all<V>(c.t[1]), q[2] - all<V>(c.t[2])};
    const V inverse_d = field(kInverseD) * farther;
    for (int r = 0; r < 3; ++r) {
      const V r0 = all<V>(c.R[0][r]), r1 = all<V>(c.R[1][r]), r2 = all<V>(c.R[2][r]);
      y[r] = r0 * d[0] + r1 * d[1] + r2 * d[2];
      k[r] = r0 * dq[0] + r1 * dq[1] + r2 * dq[2];
      const V m0 = all<V>(c.M[r][0]), m1 = all<V>(c.M[r][1]), m2 = all<V>(c.M[r][2]);
      const V turned = m0 * p[0] + m1 * p[1] + m2 * p[2];
      z[r] = turned + all<V>(c.m[r]);
      l[r] = zero - turned * inverse_d;
    }
    // At or behind the camera nothing can be judged: no weight, and an error beyond every gate.
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
    add_way(c, to_cur, y, weight, of_cur);
    add_way(c, to_ref, z, weight, of_ref);
  }
  // The perturbation (t, w) of T on the right moves y = R^T (q - t') by -t - w x y, and z = M p + m by
  // M t + (M w) x (z - m).
  double F[6][6] = {};
  for (int r = 0; r < 6; ++r) F[r][r] = -1.0;
  add_sums<Way::to_current>(F, of_cur, out);
  for (int r = 0; r < 3; ++r) {
    for (int k = 0; k < 3; ++k) {
      F[r][k] = F[3 + r][3 + k] = c.M[r][k];
      // m x (M w)
      F[r][3 + k] = c.m[(r + 1) % 3] * c.M[(r + 2) % 3][k] - c.m[(r + 2) % 3] * c.M[(r + 1) % 3][k];
    }
  }
  add_sums<Way::to_reference>(F, of_ref, out);
  out.cost += sum_lanes(cost);
}

}  // namespace
}  // namespace cliquevo::vo
