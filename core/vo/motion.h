// SPDX-License-Identifier: BSD-3-Clause
// Step A5: the rigid motion that minimises the two-way reprojection error.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/base/camera_model.h"
#include "core/base/rigid_transform.h"
#include "core/vo/clique.h"
#include "core/vo/kernels/kernels.h"
#include "core/vo/vo_params.h"

namespace cliquevo::vo {

// Closed-form rigid alignment (Horn; by SVD) of the named pairs: T_a_b minimising sum w |a - T b|^2 with weights
// 1 / (z_a^4 + z_b^4), since range errors grow with z^2. False when the points do not fix a rotation.
bool align_points(const std::vector<PointPair>& pairs, const std::vector<int>& members, RigidTransform& T_a_b);

// One feature seen in a reference frame r and in the current frame c: (u, v, disparity) in px in both.
struct Observation {
  Eigen::Vector3d uvd_ref = Eigen::Vector3d::Zero();
  Eigen::Vector3d uvd_cur = Eigen::Vector3d::Zero();
  int reference = 0;        // which reference frame (index into `T_prev_ref`)
  int feature = 0;          // caller's index
  float change = 0.0F;      // of the patch since the reference, 1 - correlation; 0 where not tracked
  float difference = 0.0F;  // between the cameras, likewise
  float brighter = 0.0F;    // than in the reference, in contrasts (RMS) of the patch there
  // written by the solver
  bool inlier = true;
  double squared_sigmas = 0.0;  // squared Mahalanobis distance, mean of both ways
  // Reprojection error as a distance in the image, after the feature's depth took its most likely value: what an
  // uncertain disparity explains is no error of the motion.
  double error_px = 0.0;
};

struct Motion {
  bool converged = false;
  RigidTransform T_prev_cur;
  Matrix6d covariance = Matrix6d::Identity();  // left perturbation [translation, rotation vector]
  int inliers = 0;
  double error_px = 0.0;  // RMS over the inliers
  // By how much all disparities seem too large, and the inverse variance of that; the motion's own share taken out.
  double offset_px = 0.0;
  double offset_information = 0.0;
  // How the motion changes (as a left perturbation) when all disparities are taken to be a pixel larger.
  Vector6d offset_sensitivity = Vector6d::Zero();
  // By how much those of the current frame alone are too large, as solved for together with the motion; what they would
  // be without the prior, and the inverse variance of that.
  double shift_px = 0.0;
  double free_shift_px = 0.0;
  double shift_information = 0.0;
};

// Where the search ends: full at 0.003 of the solution's own standard deviation, rough at 0.1.
enum class Precision { full, rough };

// Standard deviations that weigh the observations, px.
struct Sigmas {
  double position_px = 1.0;
  double disparity_px = 1.0;
  // Of an error common to the current frame's disparities, solved for together with the motion (a rig that flexes
  // has one). 0: there is none.
  double shift_px = 0.0;
};

class MotionSolver {
 public:
  MotionSolver(const StereoModel& model, const VoParams& params);

  // Levenberg-Marquardt with analytic Jacobians from `start` (and `start_shift_px`) over all observations flagged as
  // inliers, robust (Huber); then drop those beyond trim_sigmas, take in those within, and solve once more.
  // T_prev_ref[k] places reference k in the previous camera's frame; observations come grouped by reference. The first
  // is the previous frame itself; beside others it counts for a quarter. Inlier flags and errors are written back.
  Motion solve(std::vector<Observation>& observations, const std::vector<RigidTransform>& T_prev_ref,
               const RigidTransform& start, const Sigmas& sigmas, Precision precision = Precision::full,
               double start_shift_px = 0.0);

  // The same for observations of unknown, mostly much smaller noise: where the residuals show that, the solution is
  // repeated with the sigmas they show, so that a false match that comes close by chance is dropped.
  Motion solve_tightening(std::vector<Observation>& observations, const std::vector<RigidTransform>& T_prev_ref,
                          const RigidTransform& start, const Sigmas& sigmas);

  // Writes flags and errors of all observations under a given motion.
  void judge(std::vector<Observation>& observations, const std::vector<RigidTransform>& T_prev_ref,
             const RigidTransform& T_prev_cur, double shift_px, const Sigmas& sigmas);

  // Median of the squared sigmas of all observations, as last solved or judged, as a multiple of what it would be if
  // the sigmas were right; its root is the scale of the noise.
  double noise_scale(const std::vector<Observation>& observations);

 private:
  struct State {
    RigidTransform T_prev_cur;
    double shift_px = 0.0;
  };
  void load(const std::vector<Observation>& observations, const std::vector<RigidTransform>& T_prev_ref);
  void accumulate(const std::vector<RigidTransform>& T_prev_ref, const State& at, const Sigmas& sigmas,
                  MotionSums& sums) const;
  void minimise(const std::vector<RigidTransform>& T_prev_ref, const Sigmas& sigmas, Precision precision, State& at,
                MotionSums& sums) const;
  // Where observation i is in the padded arrays.
  std::size_t place(std::size_t i) const { return place_[i]; }

  StereoModel model_;
  VoParams params_;
  std::vector<double> storage_;     // kMotionFields arrays
  std::size_t capacity_ = 0;        // of each
  std::vector<MotionTerms> terms_;  // one a reference
  std::vector<std::size_t> place_;
  std::vector<double> sorted_;
};

}  // namespace cliquevo::vo
