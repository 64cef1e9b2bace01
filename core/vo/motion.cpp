// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/motion.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/SVD>

namespace cliquevo::vo {

namespace {

// Nearer than this a projected point cannot be judged: it is at or behind the camera.
constexpr double kMinDepth = 1e-3;
// A step that would gain less than this ends the search: it is three thousandths of the solution's own standard
// deviation. So does one of three hundredths that turns out to gain nothing: weights change with the motion, so that
// the least cost need not lie exactly where the normal equations have it.
constexpr double kSmallGain = 1e-5;
constexpr double kSmallGainRough = 1e-2;  // a tenth of a standard deviation
constexpr double kSmallLoss = 1e-3;
constexpr double kDamped = 1e-3;  // share of the diagonal from which on damping changes a step at all
// Beside a kept reference: where the previous frame was is known no better than what is looked for, and its error is in
// all its observations alike. At full weight error added up with the frame rate.
constexpr double kPreviousShare = 0.25;
// Tightening.
constexpr double kMedianSquaredSigmas = 2.4;  // of three components, where the sigmas are right
constexpr double kTighten = 0.5;              // of the sigmas: noise below that is worth another solution ...
constexpr double kTightest = 0.1;             // ... with sigmas of no less than this share

using Vector7d = Eigen::Matrix<double, 7, 1>;
using Matrix7d = Eigen::Matrix<double, 7, 7>;

void add(const MotionSums& part, double weight, MotionSums& sums) {
  for (int i = 0; i < 21; ++i) sums.H[i] += weight * part.H[i];
  for (int i = 0; i < 6; ++i) sums.g[i] += weight * part.g[i];
  for (int i = 0; i < 6; ++i) sums.offset_h[i] += weight * part.offset_h[i];
  sums.offset_hh += weight * part.offset_hh;
  sums.offset_g += weight * part.offset_g;
  for (int i = 0; i < 6; ++i) sums.shift_h[i] += weight * part.shift_h[i];
  sums.shift_hh += weight * part.shift_hh;
  sums.shift_g += weight * part.shift_g;
  sums.shift_offset += weight * part.shift_offset;
  sums.cost += weight * part.cost;
}

}  // namespace

bool align_points(const std::vector<PointPair>& pairs, const std::vector<int>& members, RigidTransform& T_a_b) {
  if (members.size() < 3) return false;
  Eigen::Vector3d mean_a = Eigen::Vector3d::Zero();
  Eigen::Vector3d mean_b = Eigen::Vector3d::Zero();
  double total = 0.0;
  const auto weight = [](const PointPair& p) {
    const double a2 = p.a.z() * p.a.z();
    const double b2 = p.b.z() * p.b.z();
    return 1.0 / (a2 * a2 + b2 * b2);
  };
  for (const int i : members) {
    const PointPair& p = pairs[static_cast<std::size_t>(i)];
    const double w = weight(p);
    mean_a += w * p.a;
    mean_b += w * p.b;
    total += w;
  }
  mean_a /= total;
  mean_b /= total;
  Eigen::Matrix3d S = Eigen::Matrix3d::Zero();
  for (const int i : members) {
    const PointPair& p = pairs[static_cast<std::size_t>(i)];
    S += weight(p) * (p.a - mean_a) * (p.b - mean_b).transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(S, Eigen::ComputeFullU | Eigen::ComputeFullV);
  if (!(svd.singularValues()[1] > 1e-9 * svd.singularValues()[0])) return false;
  Eigen::Vector3d sign(1.0, 1.0, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0);
  T_a_b.R = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  T_a_b.t = mean_a - T_a_b.R * mean_b;
  return T_a_b.is_finite();
}

MotionSolver::MotionSolver(const StereoModel& model, const VoParams& params) : model_(model), params_(params) {
  const std::size_t most = 2 * static_cast<std::size_t>(params.max_features);
  capacity_ = most + 2 * kMotionLanes;
  storage_.resize(capacity_ * kMotionFields);
  place_.reserve(most);
  sorted_.reserve(most);
  terms_.reserve(2);
}

// One array a quantity, each reference's part padded to whole packs.
void MotionSolver::load(const std::vector<Observation>& observations, const std::vector<RigidTransform>& T_prev_ref) {
  terms_.clear();
  place_.clear();
  std::size_t next = 0;
  std::size_t i = 0;
  for (std::size_t reference = 0; reference < T_prev_ref.size(); ++reference) {
    const RigidTransform& T_prev = T_prev_ref[reference];
    MotionTerms terms{};
    for (std::size_t f = 0; f < kMotionFields; ++f) terms.field[f] = storage_.data() + f * capacity_ + next;
    const auto put = [&](const Observation& o, double active) {
      const Eigen::Vector3d in_ref = model_.triangulate(o.uvd_ref.x(), o.uvd_ref.y(), o.uvd_ref.z());
      const Eigen::Vector3d p = model_.triangulate(o.uvd_cur.x(), o.uvd_cur.y(), o.uvd_cur.z());
      const Eigen::Vector3d q = T_prev * in_ref;
      const Eigen::Vector3d dq = T_prev.R * in_ref / -(o.uvd_ref.z() + model_.doffs_px);
      const double inverse_d = 1.0 / (o.uvd_cur.z() + model_.doffs_px);
      const double values[kMotionFields] = {
          q.x(),         q.y(),         q.z(),         dq.x(),        dq.y(),        dq.z(),
          p.x(),         p.y(),         p.z(),         inverse_d,     o.uvd_ref.x(), o.uvd_ref.y(),
          o.uvd_ref.z(), o.uvd_cur.x(), o.uvd_cur.y(), o.uvd_cur.z(), active,        0.0};
      for (std::size_t f = 0; f < kMotionFields; ++f) terms.field[f][terms.count] = values[f];
      ++terms.count;
    };
    for (; i < observations.size() && observations[i].reference == static_cast<int>(reference); ++i) {
      place_.push_back(next + static_cast<std::size_t>(terms.count));
      put(observations[i], observations[i].inlier ? 1.0 : 0.0);
    }
    while (terms.count % kMotionLanes != 0) put(observations[i - 1], 0.0);
    next += static_cast<std::size_t>(terms.count);
    terms_.push_back(terms);
  }
}

void MotionSolver::accumulate(const std::vector<RigidTransform>& T_prev_ref, const State& at, const Sigmas& sigmas,
                              MotionSums& sums) const {
  sums = {};
  MotionState state{};
  state.fx = model_.fx_px;
  state.fy = model_.fy_px;
  state.cx = model_.cx_px;
  state.cy = model_.cy_px;
  state.fx_baseline = model_.fx_px * model_.baseline_m;
  state.doffs = model_.doffs_px;
  state.weight_px = 1.0 / (sigmas.position_px * sigmas.position_px);
  state.weight_d = 1.0 / (sigmas.disparity_px * sigmas.disparity_px);
  state.variance_d = sigmas.disparity_px * sigmas.disparity_px;
  state.huber = params_.huber_sigmas;
  state.min_depth = kMinDepth;
  state.shift = at.shift_px;
  for (std::size_t k = 0; k < T_prev_ref.size(); ++k) {
    const RigidTransform T_ref_cur = T_prev_ref[k].inverse() * at.T_prev_cur;
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) {
        state.R[r][c] = at.T_prev_cur.R(r, c);
        state.M[r][c] = T_ref_cur.R(r, c);
      }
      state.t[r] = at.T_prev_cur.t[r];
      state.m[r] = T_ref_cur.t[r];
    }
    MotionSums part{};
    kernels().motion_sums(terms_[k], state, part);
    add(part, k == 0 && T_prev_ref.size() > 1 ? kPreviousShare : 1.0, sums);
  }
  if (sigmas.shift_px > 0.0) {
    const double weight = 1.0 / (sigmas.shift_px * sigmas.shift_px);
    sums.shift_hh += weight;
    sums.shift_g -= weight * at.shift_px;
    sums.cost += weight * at.shift_px * at.shift_px;
  }
}

namespace {

// Normal equations of the motion and the shift; without a shift its row is the identity's.
Matrix7d matrix_of(const MotionSums& sums, bool with_shift) {
  Matrix7d H = Matrix7d::Zero();
  int n = 0;
  for (int r = 0; r < 6; ++r) {
    for (int c = r; c < 6; ++c) H(r, c) = H(c, r) = sums.H[n++];
    if (with_shift) H(r, 6) = H(6, r) = sums.shift_h[r];
  }
  H(6, 6) = with_shift ? sums.shift_hh : 1.0;
  return H;
}

Vector7d vector_of(const double (&v)[6], double shift) {
  Vector7d out;
  out << Eigen::Map<const Vector6d>(v), shift;
  return out;
}

// What the solution yields beside the motion: its covariance (right perturbation), the shift, and the error common to
// all disparities, each with the others' share taken out.
void read_solution(const MotionSums& sums, const Sigmas& sigmas, double shift_px, const Matrix6d& Ad, Motion& out) {
  const bool with_shift = sigmas.shift_px > 0.0;
  const Eigen::LDLT<Matrix7d> solver(matrix_of(sums, with_shift));
  const Matrix7d covariance = solver.solve(Matrix7d::Identity());
  out.covariance = Ad * covariance.topLeftCorner<6, 6>() * Ad.transpose();
  const Vector7d offset_h = vector_of(sums.offset_h, with_shift ? sums.shift_offset : 0.0);
  const Vector7d sensitivity = solver.solve(offset_h);
  out.offset_sensitivity = Ad * sensitivity.head<6>();
  out.offset_information = sums.offset_hh - offset_h.dot(sensitivity);
  if (out.offset_information > 0.0) {
    const Vector7d g = vector_of(sums.g, with_shift ? sums.shift_g : 0.0);
    out.offset_px = (sums.offset_g - offset_h.dot(solver.solve(g))) / out.offset_information;
  }
  const Eigen::LDLT<Matrix6d> alone(matrix_of(sums, false).topLeftCorner<6, 6>());
  const Vector6d h = Eigen::Map<const Vector6d>(sums.shift_h);
  const double prior = with_shift ? 1.0 / (sigmas.shift_px * sigmas.shift_px) : 0.0;
  out.shift_px = shift_px;
  out.shift_information = sums.shift_hh - prior - h.dot(alone.solve(h));
  if (out.shift_information > 0.0) {
    const double g = sums.shift_g + prior * shift_px - h.dot(alone.solve(Eigen::Map<const Vector6d>(sums.g)));
    out.free_shift_px = shift_px + g / out.shift_information;
  }
  out.converged = out.covariance.allFinite() && solver.isPositive();
}

}  // namespace

void MotionSolver::minimise(const std::vector<RigidTransform>& T_prev_ref, const Sigmas& sigmas, Precision precision,
                            State& at, MotionSums& sums) const {
  const bool with_shift = sigmas.shift_px > 0.0;
  const double small_gain = precision == Precision::full ? kSmallGain : kSmallGainRough;
  accumulate(T_prev_ref, at, sigmas, sums);
  double lambda = 1e-6;
  bool is_at = true;  // each observation's error is that of `at`
  for (int iteration = 0; iteration < params_.solver_iterations; ++iteration) {
    Matrix7d H = matrix_of(sums, with_shift);
    H.diagonal() *= 1.0 + lambda;
    const Vector7d g = vector_of(sums.g, with_shift ? sums.shift_g : 0.0);
    const Vector7d step = H.ldlt().solve(g);
    const double gain = step.dot(g);
    if (!step.allFinite() || gain < small_gain) break;
    State candidate;  // the step perturbs T on the right
    const Eigen::Matrix3d dR = so3_exp(step.segment<3>(3));
    candidate.T_prev_cur.R = at.T_prev_cur.R * dR;
    candidate.T_prev_cur.t = at.T_prev_cur.t + at.T_prev_cur.R * step.head<3>();
    candidate.shift_px = at.shift_px + step[6];
    MotionSums next;
    accumulate(T_prev_ref, candidate, sigmas, next);
    is_at = next.cost <= sums.cost;
    if (is_at) {
      at = candidate;
      sums = next;
      lambda = std::max(1e-9, lambda * 0.1);
    } else {
      if (gain < std::max(small_gain, kSmallLoss)) break;
      lambda = std::max(kDamped, lambda * 10.0);
      if (lambda > 1e6) break;
    }
  }
  if (!is_at) accumulate(T_prev_ref, at, sigmas, sums);
}

double MotionSolver::noise_scale(const std::vector<Observation>& observations) {
  sorted_.clear();
  for (const Observation& o : observations) sorted_.push_back(o.squared_sigmas);
  if (sorted_.empty()) return 1.0;
  const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() / 2);
  std::nth_element(sorted_.begin(), middle, sorted_.end());
  return std::sqrt(*middle / kMedianSquaredSigmas);
}

Motion MotionSolver::solve_tightening(std::vector<Observation>& observations,
                                      const std::vector<RigidTransform>& T_prev_ref, const RigidTransform& start,
                                      const Sigmas& sigmas) {
  Motion first = solve(observations, T_prev_ref, start, sigmas);
  if (!first.converged) return first;
  sorted_.clear();
  for (const Observation& o : observations) {
    if (o.inlier) sorted_.push_back(o.squared_sigmas);
  }
  const auto middle = sorted_.begin() + static_cast<std::ptrdiff_t>(sorted_.size() / 2);
  std::nth_element(sorted_.begin(), middle, sorted_.end());
  const double scale = std::sqrt(*middle / kMedianSquaredSigmas);
  if (scale > kTighten) return first;
  const double share = std::max(scale, kTightest);
  const Motion tight = solve(observations, T_prev_ref, first.T_prev_cur,
                             {share * sigmas.position_px, share * sigmas.disparity_px, sigmas.shift_px},
                             Precision::full, first.shift_px);
  return tight.converged ? tight : first;
}

void MotionSolver::judge(std::vector<Observation>& observations, const std::vector<RigidTransform>& T_prev_ref,
                         const RigidTransform& T_prev_cur, double shift_px, const Sigmas& sigmas) {
  load(observations, T_prev_ref);
  MotionSums sums{};
  accumulate(T_prev_ref, {T_prev_cur, shift_px}, sigmas, sums);
  const double* squared = storage_.data() + static_cast<std::size_t>(kSquared) * capacity_;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    observations[i].squared_sigmas = squared[place(i)];
    observations[i].error_px = sigmas.position_px * std::sqrt(observations[i].squared_sigmas);
    observations[i].inlier = observations[i].squared_sigmas <= params_.trim_sigmas * params_.trim_sigmas;
  }
}

Motion MotionSolver::solve(std::vector<Observation>& observations, const std::vector<RigidTransform>& T_prev_ref,
                           const RigidTransform& start, const Sigmas& sigmas, Precision precision,
                           double start_shift_px) {
  Motion out;
  State at{start, sigmas.shift_px > 0.0 ? start_shift_px : 0.0};
  MotionSums sums{};
  load(observations, T_prev_ref);
  const double trim2 = params_.trim_sigmas * params_.trim_sigmas;
  const double* squared = storage_.data() + static_cast<std::size_t>(kSquared) * capacity_;
  double* active = storage_.data() + static_cast<std::size_t>(kActive) * capacity_;
  minimise(T_prev_ref, sigmas, precision, at, sums);
  bool trimmed = false;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const double keep = squared[place(i)] <= trim2 ? 1.0 : 0.0;
    trimmed = trimmed || keep != active[place(i)];
    active[place(i)] = keep;
  }
  if (trimmed) minimise(T_prev_ref, sigmas, precision, at, sums);
  double sum = 0.0;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    Observation& o = observations[i];
    o.squared_sigmas = squared[place(i)];
    o.error_px = sigmas.position_px * std::sqrt(o.squared_sigmas);
    o.inlier = active[place(i)] > 0.0 && o.squared_sigmas <= trim2;
    if (!o.inlier) continue;
    ++out.inliers;
    sum += o.error_px * o.error_px;
  }
  if (out.inliers < 3) return out;
  out.error_px = std::sqrt(sum / out.inliers);
  read_solution(sums, sigmas, at.shift_px, adjoint(at.T_prev_cur), out);  // from the right to the left of T
  out.T_prev_cur = at.T_prev_cur.normalized();
  out.converged = out.converged && at.T_prev_cur.is_finite();
  return out;
}

}  // namespace cliquevo::vo
