// SPDX-License-Identifier: BSD-3-Clause
// Step A6: is this motion right? One function per check; each gives a value, the bound that it must not exceed, and
// whether it applies at all. Bounds have no unit, or that of the camera's measured noise (core/vo/noise.h).
#pragma once

#include <array>
#include <vector>

#include "core/vo/caution.h"
#include "core/vo/evidence.h"
#include "core/vo/image_consistency.h"
#include "core/vo/motion.h"
#include "core/vo/noise.h"
#include "core/vo/vo_params.h"

namespace cliquevo::vo {

// What the checks look at.
struct CheckInput {
  const Motion& motion;
  const std::vector<Observation>& observations;  // judged by the solver
  const std::vector<RigidTransform>& T_prev_ref;
  const StereoModel& model;
  int reference_features = 0;   // that could have been found, of all references
  double shift_sigma_px = 0.0;  // width of the prior of the frame's common disparity error, as solved with
  double covered = 1.0;         // share of the picture from which inliers come, of what is enough; 0 to 1
  bool camera_repeats = false;  // one image of either frame is the one before, bit for bit
  bool speed_known = true;      // before the reference: what bends a rolling shutter's rows
};

// Those that need the solution alone; one that fails ends the attempt.
void check_solution(const CheckInput& input, const CameraNoise& noise, const Caution& caution, const VoParams& params,
                    Checks& checks);

// Enough inliers to fix a motion at all: their inverse share of the bound.
Evidence check_inliers(const CheckInput& input, const VoParams& params);
// Spread over the image: on a line they do not fix the motion (ratio of the eigenvalues of their distribution).
Evidence check_spread(const CheckInput& input, const VoParams& params);
// RMS distance of the inliers from where the motion puts them, as a multiple of what the camera's noise makes expected.
Evidence check_positions(const CheckInput& input, const CameraNoise& noise, const VoParams& params);
// The same of their disparities, which count loosely in the solution; stricter where inliers come from a small part of
// the picture.
Evidence check_disparities(const CheckInput& input, const CameraNoise& noise, const VoParams& params);
// Share of the picture's cells that moved otherwise.
Evidence check_contradiction(const CellVotes& votes, const Caution& caution, const VoParams& params);
// Ground whose texture moves (water, sand): patches change from frame to frame by more than left and right differ,
// residuals are large, and near and far ground imply an error of the disparities that was not there before.
Evidence check_running_ground(const CheckInput& input, const CameraNoise& noise, const Caution& caution,
                              const VoParams& params, std::vector<float>& scratch);
// A camera that repeats its last image: features move in one image and stand still in the other. Certain where the
// image is the one before, bit for bit.
Evidence check_hanging_camera(const CheckInput& input, const CameraNoise& noise, std::vector<float>& scratch);
// After a suspicious frame: a good share of the reference's features must be found again.
Evidence check_found_again(const CheckInput& input, const Caution& caution);
// Standard deviation of the translation, by its covariance, as a share of what makes a motion known.
Evidence check_uncertainty(const CheckInput& input, const Matrix6d& covariance, const VoParams& params);

// Spread of the inliers in the current image: smaller over larger eigenvalue of the covariance of their positions.
// 0: on a line; 1: round. 0 for fewer than three.
double spread_ratio(const std::vector<Observation>& observations);

// How far the inliers' disparities in the current frame are from where the motion puts them, px, RMS.
double disparity_error_px(const CheckInput& input);

// How unevenly the brightness of the inliers changed since the (first) reference, in contrasts of their patches: 90th
// percentile of each one's deviation from the common change. A glow that comes or goes shifts every feature along its
// gradient.
double change_of_light(const std::vector<Observation>& observations, std::vector<float>& scratch);

}  // namespace cliquevo::vo
