// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/rigid_transform.h"

#include <algorithm>
#include <cmath>

namespace cliquevo {

RigidTransform RigidTransform::inverse() const {
  RigidTransform out;
  out.R = R.transpose();
  out.t = -(out.R * t);
  return out;
}

RigidTransform RigidTransform::operator*(const RigidTransform& other) const {
  RigidTransform out;
  out.R = R * other.R;
  out.t = R * other.t + t;
  return out;
}

double RigidTransform::angle() const { return so3_log(R).norm(); }

RigidTransform RigidTransform::normalized() const {
  Eigen::Quaterniond q(R);
  q.normalize();
  RigidTransform out;
  out.R = q.toRotationMatrix();
  out.t = t;
  return out;
}

Eigen::Matrix3d skew(const Eigen::Vector3d& v) {
  Eigen::Matrix3d S;
  S << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return S;
}

Eigen::Matrix3d so3_exp(const Eigen::Vector3d& rotation_vector) {
  const double angle = rotation_vector.norm();
  const Eigen::Matrix3d S = skew(rotation_vector);
  double a = 1.0;
  double b = 0.5;
  if (angle > 1e-5) {
    a = std::sin(angle) / angle;
    b = (1.0 - std::cos(angle)) / (angle * angle);
  } else {  // Taylor: the closed form loses its digits near zero
    a = 1.0 - angle * angle / 6.0;
    b = 0.5 - angle * angle / 24.0;
  }
  return Eigen::Matrix3d::Identity() + a * S + b * S * S;
}

Eigen::Vector3d so3_log(const Eigen::Matrix3d& R) {
  // Through the quaternion: well conditioned at 0 and at pi.
  Eigen::Quaterniond q(R);
  q.normalize();
  if (q.w() < 0.0) q.coeffs() = -q.coeffs();
  const double s = q.vec().norm();
  if (s < 1e-12) return 2.0 * q.vec();
  return 2.0 * std::atan2(s, q.w()) / s * q.vec();
}

RigidTransform perturb_left(const RigidTransform& T, const Vector6d& delta) {
  const Eigen::Matrix3d dR = so3_exp(delta.tail<3>());
  RigidTransform out;
  out.R = dR * T.R;
  out.t = dR * T.t + delta.head<3>();
  return out;
}

Vector6d left_difference(const RigidTransform& from, const RigidTransform& to) {
  const Eigen::Matrix3d dR = to.R * from.R.transpose();
  Vector6d out;
  out.head<3>() = to.t - dR * from.t;
  out.tail<3>() = so3_log(dR);
  return out;
}

Matrix6d adjoint(const RigidTransform& T) {
  Matrix6d A = Matrix6d::Zero();
  A.topLeftCorner<3, 3>() = T.R;
  A.bottomRightCorner<3, 3>() = T.R;
  A.topRightCorner<3, 3>() = skew(T.t) * T.R;
  return A;
}

}  // namespace cliquevo
