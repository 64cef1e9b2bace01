// SPDX-License-Identifier: BSD-3-Clause
// Rigid motions. `T_a_b` takes a point in frame b to frame a: p_a = T_a_b * p_b.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace cliquevo {

using Vector6d = Eigen::Matrix<double, 6, 1>;  // [translation, rotation vector]
using Matrix6d = Eigen::Matrix<double, 6, 6>;  // of such

// A rotation and a translation: p_a = R p_b + t.
struct RigidTransform {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  // rotation
  Eigen::Vector3d t = Eigen::Vector3d::Zero();      // m

  // T_b_a of T_a_b.
  RigidTransform inverse() const;
  // T_a_c = T_a_b * T_b_c.
  RigidTransform operator*(const RigidTransform& other) const;
  // A point taken over.
  Eigen::Vector3d operator*(const Eigen::Vector3d& point) const { return R * point + t; }
  // Whether all its numbers are.
  bool is_finite() const { return R.allFinite() && t.allFinite(); }
  // Rotation angle in radians, 0 to pi.
  double angle() const;
  // R brought back onto SO(3); long products of transforms need it now and then.
  RigidTransform normalized() const;
};

// [v]x: skew(v) w = v x w.
Eigen::Matrix3d skew(const Eigen::Vector3d& v);
// Rotation matrix of a rotation vector, rad.
Eigen::Matrix3d so3_exp(const Eigen::Vector3d& rotation_vector);
// Rotation vector of a rotation matrix, rad; its length is 0 to pi.
Eigen::Vector3d so3_log(const Eigen::Matrix3d& R);

// T perturbed on the left, in the frame T maps to, by [translation, rotation vector]: to first order the delta whose
// covariance the messages carry. perturb_left(T, x).t = exp(x_rot) T.t + x_trans.
RigidTransform perturb_left(const RigidTransform& T, const Vector6d& delta);
// The perturbation of `to` relative to `from`: perturb_left(from, left_difference(from, to)) == to.
Vector6d left_difference(const RigidTransform& from, const RigidTransform& to);
// Adjoint for that ordering [translation, rotation]: the perturbation x of T_a_a' seen from frame b = Ad(T_b_a) x.
Matrix6d adjoint(const RigidTransform& T);

}  // namespace cliquevo
