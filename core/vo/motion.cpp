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

using Matrix36 = Eigen::Matrix<double, 3, 6>;

// (u, v, d) of a point in the left camera's frame.
Eigen::Vector3d project(const StereoModel& m, const Eigen::Vector3d& p) {
  const double inverse_z = 1.0 / p.z();
  return {m.fx_px * p.x() * inverse_z + m.cx_px, m.fy_px * p.y() * inverse_z + m.cy_px,
          m.fx_px * m.baseline_m * inverse_z - m.doffs_px};
}

Eigen::Matrix3d projection_jacobian(const StereoModel& m, const Eigen::Vector3d& p) {
  const double iz = 1.0 / p.z();
  Eigen::Matrix3d J;
  J << m.fx_px * iz, 0, -m.fx_px * p.x() * iz * iz,  //
      0, m.fy_px * iz, -m.fy_px * p.y() * iz * iz,   //
      0, 0, -m.fx_px * m.baseline_m * iz * iz;
  return J;
}

// Inverse of diag(sp^2, sp^2, sd^2) + sd^2 j j^T: the noise of an observation in one frame, and of its prediction from
// the other frame, whose depth rests on a disparity with the same noise (j: change of the prediction with it).
Eigen::Matrix3d information(double sigma_px, double sigma_d_px, const Eigen::Vector3d& j) {
  const Eigen::Vector3d w(1.0 / (sigma_px * sigma_px), 1.0 / (sigma_px * sigma_px), 1.0 / (sigma_d_px * sigma_d_px));
  const Eigen::Vector3d wj = w.cwiseProduct(j);
  const double s = sigma_d_px * sigma_d_px / (1.0 + sigma_d_px * sigma_d_px * j.dot(wj));
  return Eigen::Matrix3d(w.asDiagonal()) - s * wj * wj.transpose();
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

MotionSolver::MotionSolver(const StereoModel& model, const VoParams& params) : model_(model), params_(params) {}

double MotionSolver::accumulate(std::vector<Observation>& observations, const std::vector<RigidTransform>& T_prev_ref,
                                const RigidTransform& T, Normal* normal) const {
  const double huber = params_.huber_sigmas;
  const Eigen::Matrix3d Rt = T.R.transpose();
  double cost = 0.0;
  if (normal != nullptr) {
    normal->H.setZero();
    normal->g.setZero();
    normal->offset_h.setZero();
    normal->offset_hh = 0.0;
    normal->offset_g = 0.0;
  }
  for (Observation& o : observations) {
    const RigidTransform& T_prev = T_prev_ref[static_cast<std::size_t>(o.reference)];
    const Eigen::Vector3d point_ref = model_.triangulate(o.uvd_ref.x(), o.uvd_ref.y(), o.uvd_ref.z());
    const Eigen::Vector3d point_cur = model_.triangulate(o.uvd_cur.x(), o.uvd_cur.y(), o.uvd_cur.z());
    // Forward: reference -> current.
    const Eigen::Vector3d q = T_prev * point_ref;
    const Eigen::Vector3d in_cur = Rt * (q - T.t);
    // Backward: current -> reference.
    const Eigen::Vector3d moved = T * point_cur;
    const Eigen::Matrix3d R_ref_prev = T_prev.R.transpose();
    const Eigen::Vector3d in_ref = R_ref_prev * (moved - T_prev.t);
    if (in_cur.z() < kMinDepth || in_ref.z() < kMinDepth) {
      o.squared_sigmas = 1e12;
      o.error_px = 1e6;
      if (o.inlier) cost += huber * 1e6;
      continue;
    }
    const Eigen::Vector3d e_cur = o.uvd_cur - project(model_, in_cur);
    const Eigen::Vector3d e_ref = o.uvd_ref - project(model_, in_ref);
    const Eigen::Matrix3d J_cur = projection_jacobian(model_, in_cur);
    const Eigen::Matrix3d J_ref = projection_jacobian(model_, in_ref);
    // d point / d disparity = -point / (d + doffs)
    const Eigen::Vector3d j_cur = J_cur * (Rt * (T_prev.R * (-point_ref / (o.uvd_ref.z() + model_.doffs_px))));
    const Eigen::Vector3d j_ref = J_ref * (R_ref_prev * (T.R * (-point_cur / (o.uvd_cur.z() + model_.doffs_px))));
    const Eigen::Matrix3d W_cur = information(o.sigma_px, o.sigma_d_px, j_cur);
    const Eigen::Matrix3d W_ref = information(o.sigma_px, o.sigma_d_px, j_ref);
    // Both ways see the same noise: each counts half.
    const double m2 = 0.5 * (e_cur.dot(W_cur * e_cur) + e_ref.dot(W_ref * e_ref));
    o.squared_sigmas = m2;
    o.error_px = o.sigma_px * std::sqrt(m2);
    if (!o.inlier) continue;
    const double m = std::sqrt(m2);
    const double weight = m <= huber ? 1.0 : huber / m;
    cost += m <= huber ? m2 : huber * (2.0 * m - huber);
    if (normal == nullptr) continue;
    Matrix36 D_cur;  // of the point in the current frame with the perturbation of T
    D_cur.leftCols<3>() = -Rt;
    D_cur.rightCols<3>() = Rt * skew(q);
    Matrix36 D_ref;
    D_ref.leftCols<3>() = R_ref_prev;
    D_ref.rightCols<3>() = -R_ref_prev * skew(moved);
    const Matrix36 A_cur = J_cur * D_cur;
    const Matrix36 A_ref = J_ref * D_ref;
    const Matrix36 WA_cur = (0.5 * weight) * (W_cur * A_cur);
    const Matrix36 WA_ref = (0.5 * weight) * (W_ref * A_ref);
    normal->H.noalias() += A_cur.transpose() * WA_cur;
    normal->H.noalias() += A_ref.transpose() * WA_ref;
    normal->g.noalias() += WA_cur.transpose() * e_cur;
    normal->g.noalias() += WA_ref.transpose() * e_ref;
    // The same for an error common to all disparities: taking it off moves the observation and the prediction.
    const Eigen::Vector3d a_cur = Eigen::Vector3d::UnitZ() - j_cur;
    const Eigen::Vector3d a_ref = Eigen::Vector3d::UnitZ() - j_ref;
    const Eigen::Vector3d Wa_cur = (0.5 * weight) * (W_cur * a_cur);
    const Eigen::Vector3d Wa_ref = (0.5 * weight) * (W_ref * a_ref);
    normal->offset_h.noalias() += A_cur.transpose() * Wa_cur;
    normal->offset_h.noalias() += A_ref.transpose() * Wa_ref;
    normal->offset_hh += a_cur.dot(Wa_cur) + a_ref.dot(Wa_ref);
    normal->offset_g += Wa_cur.dot(e_cur) + Wa_ref.dot(e_ref);
  }
  if (normal != nullptr) normal->cost = cost;
  return cost;
}

void MotionSolver::minimise(std::vector<Observation>& observations, const std::vector<RigidTransform>& T_prev_ref,
                            RigidTransform& T, Normal& normal) const {
  accumulate(observations, T_prev_ref, T, &normal);
  double lambda = 1e-6;
  for (int iteration = 0; iteration < params_.solver_iterations; ++iteration) {
    Matrix6d H = normal.H;
    H.diagonal() *= 1.0 + lambda;
    const Eigen::LDLT<Matrix6d> solver(H);
    const Vector6d step = solver.solve(normal.g);
    if (!step.allFinite()) return;
    const RigidTransform candidate = perturb_left(T, step);
    Normal next;
    accumulate(observations, T_prev_ref, candidate, &next);
    if (next.cost <= normal.cost) {
      T = candidate;
      normal = next;
      lambda = std::max(1e-9, lambda * 0.1);
      if (step.head<3>().norm() < 1e-7 && step.tail<3>().norm() < 1e-8) break;
    } else {
      lambda *= 10.0;
      if (lambda > 1e6) break;
    }
  }
  // Leave each observation's error as of the final T.
  accumulate(observations, T_prev_ref, T, &normal);
}

Motion MotionSolver::solve(std::vector<Observation>& observations, const std::vector<RigidTransform>& T_prev_ref,
                           const RigidTransform& start) const {
  Motion out;
  RigidTransform T = start;
  Normal normal;
  const double trim2 = params_.trim_sigmas * params_.trim_sigmas;
  for (int round = 0; round < 2; ++round) {
    minimise(observations, T_prev_ref, T, normal);
    if (round == 1) break;
    for (Observation& o : observations) o.inlier = o.squared_sigmas <= trim2;
  }
  double sum = 0.0;
  for (Observation& o : observations) {
    o.inlier = o.inlier && o.squared_sigmas <= trim2;
    if (!o.inlier) continue;
    ++out.inliers;
    sum += o.error_px * o.error_px;
  }
  if (out.inliers < 3) return out;
  out.error_px = std::sqrt(sum / out.inliers);
  const Eigen::LDLT<Matrix6d> solver(normal.H);
  out.covariance = solver.solve(Matrix6d::Identity());
  out.offset_information = normal.offset_hh - normal.offset_h.dot(solver.solve(normal.offset_h));
  if (out.offset_information > 0.0) {
    out.offset_px = (normal.offset_g - normal.offset_h.dot(solver.solve(normal.g))) / out.offset_information;
  }
  out.T_prev_cur = T.normalized();
  out.converged = T.is_finite() && out.covariance.allFinite() && solver.isPositive();
  return out;
}

}  // namespace cliquevo::vo
