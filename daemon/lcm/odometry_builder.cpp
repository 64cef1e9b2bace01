// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/lcm/odometry_builder.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "core/vo/noise.h"
#include "daemon/lcm/messages.h"

namespace cliquevo::daemon {

namespace {

constexpr double kLargestVariance = 1e9;
// At the start the pose is exact by definition; filters invert covariances.
constexpr double kStartVariance_m2 = 1e-8;
constexpr double kStartVariance_rad2 = 1e-9;
constexpr double kJump_m = 0.1;
constexpr double kJump_rad = 0.035;

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d out;
  out << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return out;
}

Matrix6d start_covariance() {
  Vector6d diagonal;
  diagonal << Eigen::Vector3d::Constant(kStartVariance_m2), Eigen::Vector3d::Constant(kStartVariance_rad2);
  return diagonal.asDiagonal();
}

// Symmetric to the bit. Where a variance is too large, its row and column shrink with it, so that it stays one.
Matrix6d bounded(const Matrix6d& covariance) {
  if (!covariance.allFinite()) return Matrix6d::Identity() * kUnknownVariance;
  Matrix6d out = 0.5 * (covariance + covariance.transpose());
  for (int i = 0; i < 6; ++i) {
    if (out(i, i) <= kLargestVariance) continue;
    const double factor = std::sqrt(kLargestVariance / out(i, i));
    out.row(i) *= factor;
    out.col(i) *= factor;
  }
  return out;
}

void store(const Eigen::Vector3d& v, double (&out)[3]) {
  for (int i = 0; i < 3; ++i) out[i] = v[i];
}
void store(const Matrix6d& M, double (&out)[6][6]) {
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) out[r][c] = M(r, c);
  }
}

// One number for a covariance, by its root: the geometric mean of its variances along its axes.
double size_of(const Matrix6d& root) { return std::exp(root.diagonal().array().log().sum() / 3.0); }

}  // namespace

PoseCovariance::PoseCovariance()
    : matrix_(start_covariance()), lasting_(matrix_), last_noise_(0.0), shared_(Matrix6d::Zero()) {}

// The errors of motion k are L_k / sqrt(c_k) (sqrt(n_k) x_k - sqrt(n_k-1) x_k-1 + sqrt(n_k) y_k), where L_k L_k^T is
// its covariance and c_k its size, n_k the noise of its last image, x_k white, and y_k a little of a Gauss-Markov
// process: their joint covariance is exact, so that what comes of it is one. Of a noisy camera's own part the white
// share is taken back in the end, and only `lasting` of it is added up.
void PoseCovariance::add(const Eigen::Matrix3d& R_before, const Eigen::Vector3d& moved, const Matrix6d& delta,
                         double lasting, Motion motion) {
  // p = p0 + R0 t, R = R0 dR; the delta's perturbation (a, b) makes t + a + b x t and exp(b) dR of them.
  Matrix6d F = Matrix6d::Identity();
  F.topRightCorner<3, 3>() = -cross(R_before * moved);
  Matrix6d G = Matrix6d::Zero();
  G.topLeftCorner<3, 3>() = R_before;
  G.topRightCorner<3, 3>() = -R_before * cross(moved);
  G.bottomRightCorner<3, 3>() = R_before;
  static const double fade = std::exp(-1.0 / kSharedMotions);
  const Matrix6d in_common = fade * F * shared_;
  if (motion != Motion::next) {  // from another image than the last one, whose noise nothing takes back
    lasting_ = matrix_;
    last_noise_ = 0.0;
  }
  const Eigen::LLT<Matrix6d> root(delta);
  if (motion == Motion::guess || root.info() != Eigen::Success || !delta.allFinite()) {
    matrix_ = F * matrix_ * F.transpose() + G * delta * G.transpose();
    lasting_ = matrix_;
    last_noise_ = 0.0;
    shared_ = in_common;
    return;
  }
  const double size = size_of(root.matrixL());
  last_noise_ = 0.5 * std::max(size - last_noise_, kLeastNew * size);
  const Matrix6d own = std::sqrt(last_noise_ / size) * G * Matrix6d(root.matrixL());
  const Matrix6d of_many = std::sqrt(kShared * lasting) * own;
  const Matrix6d with_pose = in_common * of_many.transpose();
  lasting_ = F * lasting_ * F.transpose() + lasting * own * own.transpose() + with_pose + with_pose.transpose();
  shared_ = in_common + of_many;
  matrix_ = lasting_ + own * own.transpose();
}

double PoseCovariance::lasting_part(double expected_error_px) {
  const double ratio = expected_error_px / vo::CameraNoise::kAlignmentError_px;
  const double image_noise = std::max(0.0, ratio * ratio - 1.0);
  return std::min(1.0, kLasting / (1.0 + kWhite * image_noise * image_noise));
}

OdometryBuilder::OdometryBuilder(const RigidTransform& T_body_camera)
    : T_body_camera_(T_body_camera),
      T_camera_body_(T_body_camera.inverse()),
      adjoint_body_camera_(adjoint(T_body_camera)) {}

RigidTransform OdometryBuilder::body_pose(const vo::Estimate& e) const {
  return (T_body_camera_ * e.T_world_camera * T_camera_body_).normalized();
}

void OdometryBuilder::start(const vo::Estimate& e, bool usable) {
  valid_ = State{usable ? body_pose(e) : RigidTransform{}, PoseCovariance(), e.stamp_ns};
  shown_ = *valid_;
  guessed_ = false;
  twist_ = {};
  twist_.covariance = Matrix6d::Identity() * kUnknownVariance;
}

void OdometryBuilder::follow(const vo::Estimate& e) {
  const RigidTransform T = T_body_camera_ * e.T_prev_cur * T_camera_body_;
  const Matrix6d delta = adjoint_body_camera_ * e.covariance * adjoint_body_camera_.transpose();
  State now{body_pose(e), valid_->covariance, e.stamp_ns};
  using Motion = PoseCovariance::Motion;
  now.covariance.add(valid_->T_odom_body.R, T.t, delta, PoseCovariance::lasting_part(e.expected_error_px),
                     guessed_ ? Motion::after_gap : Motion::next);
  if (guessed_ && is_jump(now)) ++reset_counter_;
  const double dt_s = std::max(1e-6, static_cast<double>(e.stamp_ns - e.prev_stamp_ns) * 1e-9);
  twist_.velocity = T.R.transpose() * T.t / dt_s;
  twist_.rotation_rate = so3_log(T.R) / dt_s;
  // In the frame that the motion ended in, its perturbation (a, b) makes R^T a and R^T b.
  Matrix6d A = Matrix6d::Zero();
  A.topLeftCorner<3, 3>() = T.R.transpose();
  A.bottomRightCorner<3, 3>() = T.R.transpose();
  twist_.covariance = A * delta * A.transpose() / (dt_s * dt_s);
  valid_ = now;
  shown_ = now;
  guessed_ = false;
}

// The guess and its covariance are since the last valid frame.
void OdometryBuilder::carry_on(const vo::Estimate& e, bool usable) {
  State now{usable ? body_pose(e) : shown_.T_odom_body, valid_->covariance, e.stamp_ns};
  const Eigen::Matrix3d& R = valid_->T_odom_body.R;
  const Eigen::Vector3d moved = R.transpose() * (now.T_odom_body.t - valid_->T_odom_body.t);
  const Matrix6d guess = usable ? e.covariance : Matrix6d::Identity() * kUnknownVariance;
  now.covariance.add(R, moved, adjoint_body_camera_ * guess * adjoint_body_camera_.transpose(), 1.0,
                     PoseCovariance::Motion::guess);
  twist_.covariance = Matrix6d::Identity() * kUnknownVariance;
  shown_ = now;
  guessed_ = true;
}

bool OdometryBuilder::is_jump(const State& now) const {
  const double dt_s = static_cast<double>(now.stamp_ns - shown_.stamp_ns) * 1e-9;
  RigidTransform step;
  step.R = so3_exp(dt_s * twist_.rotation_rate);
  step.t = dt_s * twist_.velocity;
  const RigidTransform off = (shown_.T_odom_body * step).inverse() * now.T_odom_body;
  return off.t.norm() > kJump_m || so3_log(off.R).norm() > kJump_rad;
}

void OdometryBuilder::build(const PublishedFrame& frame, bool usable, TimestampNs publish_ns, odometry_t& out) {
  const vo::Estimate& e = frame.estimate;
  const bool anew = !valid_ || frame.resets != resets_;
  if (valid_ && anew) ++reset_counter_;
  resets_ = frame.resets;
  out.prev_utime = floor_us(anew ? e.stamp_ns : valid_->stamp_ns);
  const bool measured = usable && e.status == vo::Status::valid;
  if (anew || e.status == vo::Status::no_data) {
    start(e, usable);
  } else if (measured) {
    follow(e);
  } else {
    carry_on(e, usable);
  }
  out.utime = floor_us(e.stamp_ns);
  out.publish_utime = floor_us(publish_ns);
  store(shown_.T_odom_body.t, out.position);
  Eigen::Quaterniond q(shown_.T_odom_body.R);
  q.normalize();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  out.orientation[0] = q.w();
  for (int i = 0; i < 3; ++i) out.orientation[i + 1] = q.vec()[i];
  store(bounded(shown_.covariance.matrix()), out.pose_covariance);
  store(twist_.velocity, out.velocity);
  store(twist_.rotation_rate, out.rotation_rate);
  store(bounded(twist_.covariance), out.twist_covariance);
  out.quality = measured ? static_cast<std::int8_t>(e.quality) : std::int8_t{0};
  out.status = static_cast<std::int8_t>(e.status);
  out.pose_is_guess = guessed_ ? 1 : 0;
  out.reset_counter = reset_counter_;
}

}  // namespace cliquevo::daemon
