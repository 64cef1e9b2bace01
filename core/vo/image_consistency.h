// SPDX-License-Identifier: BSD-3-Clause
// Step A6 beyond the paper: does the image as a whole move as estimated? The clique is made of matches alone. An object
// of high contrast before weakly textured ground gives all corners, all matches and a perfect clique, though most of
// the world moves otherwise. So the image is divided into cells, and a patch of known depth is tested in each of them.
#pragma once

#include <vector>

#include "core/base/camera_model.h"
#include "core/vo/frame.h"
#include "core/vo/motion.h"
#include "core/vo/patch.h"
#include "core/vo/self_check.h"
#include "core/vo/tracking.h"

namespace cliquevo::vo {

// Cells of the reference's image.
struct CellVotes {
  int agree = 0;       // something in it moved as predicted
  int inliers = 0;     // even an inlier
  int cells = 0;       // in all
  int contradict = 0;  // its texture is not where the motion predicts it, though nothing hides that place
  double coverage() const { return cells > 0 ? static_cast<double>(inliers) / cells : 0.0; }
  double share() const { return agree + contradict > 0 ? static_cast<double>(contradict) / (agree + contradict) : 0.0; }
};

class ImageConsistency {
 public:
  explicit ImageConsistency(const StereoModel& model);

  // The best textured place of known depth in each cell that has no feature.
  void choose_test_patches(ImageView<const std::int16_t> disparity, Frame& frame);
  // `observations`: of the reference (index 0), judged. `disparity`: of the current frame. Every patch that is not
  // found contradicts, also one of a repeated pattern, or (slower) unique ones alone.
  enum class Contradicts : std::uint8_t { any, unique };
  CellVotes count(const Frame& reference, const Frame& current, ImageView<const std::int16_t> disparity,
                  const RigidTransform& T_ref_cur, const ViewErrors& errors,
                  const std::vector<Observation>& observations, Contradicts which);

 private:
  enum class Vote : std::uint8_t { none, contradicts, agrees };
  Vote test_patch(const Feature& place, const Frame& reference, const Frame& current,
                  ImageView<const std::int16_t> disparity, const RigidTransform& T_cur_ref, const ViewErrors& errors,
                  Contradicts which) const;
  bool repeated(const Template& patch, const Feature& place, const Frame& reference, float correlation, double du,
                double dv) const;
  std::size_t cell_of(int x, int y) const {
    return static_cast<std::size_t>(y / side_px_) * static_cast<std::size_t>(across_) +
           static_cast<std::size_t>(x / side_px_);
  }

  StereoModel model_;
  RollingShutter shutter_;
  PatchParams patch_;
  int side_px_ = 0;  // of a cell
  int across_ = 0;   // cells
  int down_ = 0;
  std::vector<std::uint8_t> has_feature_;  // of each cell
  std::vector<std::uint8_t> tested_;       // patches of each cell that voted
  std::vector<Vote> votes_;
};

}  // namespace cliquevo::vo
