// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/rigid_transform.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace cliquevo {
namespace {

Vector6d random_vector(std::mt19937& rng, double translation, double rotation) {
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  Vector6d v;
  for (int i = 0; i < 3; ++i) v[i] = translation * u(rng);
  for (int i = 3; i < 6; ++i) v[i] = rotation * u(rng);
  return v;
}

TEST(RigidTransform, SkewIsTheCrossProduct) {
  const Eigen::Vector3d v(1.0, -2.0, 3.0), w(0.5, 4.0, -1.0);
  EXPECT_EQ(skew(v) * w, v.cross(w));
  EXPECT_EQ(skew(v).transpose(), -skew(v));
}

TEST(RigidTransform, ExponentialAndLogarithmInvertEachOtherFromTinyToNearlyHalfATurn) {
  std::mt19937 rng(1);
  for (const double size : {0.0, 1e-12, 1e-8, 1e-5, 1e-3, 0.1, 1.0, 1.7}) {
    for (int i = 0; i < 50; ++i) {
      const Eigen::Vector3d w = random_vector(rng, 0, size).tail<3>();
      const Eigen::Matrix3d R = so3_exp(w);
      EXPECT_NEAR((R * R.transpose() - Eigen::Matrix3d::Identity()).norm(), 0.0, 1e-12);
      EXPECT_NEAR((so3_log(R) - w).norm(), 0.0, 1e-9) << "size " << size;
    }
  }
}

TEST(RigidTransform, InverseUndoesTheTransform) {
  std::mt19937 rng(2);
  for (int i = 0; i < 50; ++i) {
    const RigidTransform T = perturb_left({}, random_vector(rng, 10.0, 1.5));
    const RigidTransform I = T * T.inverse();
    EXPECT_NEAR((I.R - Eigen::Matrix3d::Identity()).norm(), 0.0, 1e-12);
    EXPECT_NEAR(I.t.norm(), 0.0, 1e-12);
  }
}

TEST(RigidTransform, LeftDifferenceIsWhatPerturbLeftApplied) {
  std::mt19937 rng(3);
  for (int i = 0; i < 50; ++i) {
    const RigidTransform T = perturb_left({}, random_vector(rng, 5.0, 1.0));
    const Vector6d x = random_vector(rng, 0.5, 0.3);
    EXPECT_NEAR((left_difference(T, perturb_left(T, x)) - x).norm(), 0.0, 1e-10);
  }
}

TEST(RigidTransform, AdjointCarriesAPerturbationThroughAProduct) {
  std::mt19937 rng(4);
  for (int i = 0; i < 50; ++i) {
    const RigidTransform A = perturb_left({}, random_vector(rng, 5.0, 1.0));
    const RigidTransform B = perturb_left({}, random_vector(rng, 5.0, 1.0));
    const Vector6d x = 1e-6 * random_vector(rng, 1.0, 1.0);
    const RigidTransform moved = A * perturb_left(B, x);
    const Vector6d seen = left_difference(A * B, moved);
    EXPECT_NEAR((seen - adjoint(A) * x).norm(), 0.0, 1e-10);
  }
}

}  // namespace
}  // namespace cliquevo
