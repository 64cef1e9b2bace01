// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/rolling_shutter.h"

#include <Eigen/Cholesky>

#include "core/vo/frame.h"

namespace cliquevo::vo {

namespace {
constexpr double kNearest_m = 0.05;  // nearer, or behind the camera: not seen
}

RigidTransform RollingShutter::T_stamp_row(const Velocity& velocity, double row_px) const {
  const double later = later_s(row_px);
  RigidTransform T;
  T.R = so3_exp(later * velocity.tail<3>());
  T.t = later * velocity.head<3>();
  return T;
}

Eigen::Vector3d RollingShutter::at_stamp(const StereoModel& model, const Velocity& velocity,
                                         const Eigen::Vector3d& uvd) const {
  const Eigen::Vector3d p = T_stamp_row(velocity, uvd.y()) * model.triangulate(uvd.x(), uvd.y(), uvd.z());
  return p.z() < kNearest_m ? uvd : model.project(p);
}

namespace {

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d S;
  S << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return S;
}

Eigen::Matrix3d projection_jacobian(const StereoModel& m, const Eigen::Vector3d& p) {
  const double per_z = 1.0 / p.z();
  Eigen::Matrix3d J;
  J << m.fx_px * per_z, 0.0, -m.fx_px * p.x() * per_z * per_z,  //
      0.0, m.fy_px * per_z, -m.fy_px * p.y() * per_z * per_z,   //
      0.0, 0.0, -m.fx_px * m.baseline_m * per_z * per_z;
  return J;
}

}  // namespace

TurnFit fit_turn(const std::vector<Observation>& observations, const std::vector<RigidTransform>& T_prev_ref,
                 const Motion& motion, const StereoModel& model, const Sigmas& sigmas, double prior_rad_s) {
  using Matrix9d = Eigen::Matrix<double, 9, 9>;
  using Vector9d = Eigen::Matrix<double, 9, 1>;
  const RollingShutter shutter(model);
  Matrix9d H = Matrix9d::Zero();
  Vector9d g = Vector9d::Zero();
  const Eigen::Vector3d weight(1.0 / (sigmas.position_px * sigmas.position_px),
                               1.0 / (sigmas.position_px * sigmas.position_px),
                               0.5 / (sigmas.disparity_px * sigmas.disparity_px));
  for (const Observation& o : observations) {
    if (!o.inlier) continue;
    const RigidTransform T_cur_ref = motion.T_prev_cur.inverse() * T_prev_ref[static_cast<std::size_t>(o.reference)];
    const Eigen::Vector3d y = T_cur_ref * model.triangulate(o.uvd_ref.x(), o.uvd_ref.y(), o.uvd_ref.z());
    if (y.z() < kNearest_m) continue;
    Eigen::Vector3d e = o.uvd_cur - model.project(y);
    e.z() -= motion.shift_px;
    const Eigen::Matrix3d J = projection_jacobian(model, y);
    Eigen::Matrix<double, 3, 9> A;
    A.leftCols<3>() = -J;
    A.middleCols<3>(3) = J * skew(y);
    A.rightCols<3>() = shutter.later_s(o.uvd_cur.y()) * J * skew(y);
    H += A.transpose() * weight.asDiagonal() * A;
    g += A.transpose() * (weight.asDiagonal() * e);
  }
  TurnFit out;
  const Matrix6d known = H.topLeftCorner<6, 6>();
  H.diagonal().tail<3>().array() += 1.0 / (prior_rad_s * prior_rad_s);
  const Eigen::LDLT<Matrix9d> solver(H);
  const Vector9d x = solver.solve(g);
  if (!solver.isPositive() || !x.allFinite()) return out;
  out.rate = x.tail<3>();
  const Matrix9d covariance = solver.solve(Matrix9d::Identity());
  const Matrix6d more = covariance.topLeftCorner<6, 6>() - known.ldlt().solve(Matrix6d::Identity());
  const Matrix6d Ad = adjoint(motion.T_prev_cur);
  if (more.allFinite()) out.covariance = Ad * more * Ad.transpose();
  return out;
}

Velocity velocity_of(const RigidTransform& motion, TimestampNs interval_ns) {
  const double interval_s = 1e-9 * static_cast<double>(interval_ns);
  Velocity v;
  v << motion.t, so3_log(motion.R);
  return v / interval_s;
}

Velocities velocities(const Frame& reference, const Frame& current, const RigidTransform& T_ref_cur) {
  Velocities out;
  out.before = velocity_of(T_ref_cur, current.stamp_ns - reference.stamp_ns);
  const Velocity before_that = reference.velocity_before.isZero() ? out.before : reference.velocity_before;
  out.reference = 0.5 * (before_that + out.before);
  out.reference.tail<3>() += reference.turn_rate;
  out.current = out.before + 0.5 * (out.before - before_that);
  return out;
}

}  // namespace cliquevo::vo
