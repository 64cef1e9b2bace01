// SPDX-License-Identifier: BSD-3-Clause
// The picture of a run: the trajectory from above, and beside it the error over distance.
#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/base/rigid_transform.h"
#include "tools/evaluation.h"
#include "tools/picture_format.h"

namespace cliquevo::tools {

struct RunPicture {
  std::string title;                       // UTF-8
  std::vector<RigidTransform> trajectory;  // rectified left camera in its first frame, a pose a frame
  std::vector<std::size_t> failed;         // indices of frames without a valid estimate
  std::vector<int> inliers;                // a frame, may be empty
  std::vector<PosePair> pairs;             // with the reference; empty = none
  bool align = false;                      // fit the reference rigidly instead of putting first poses onto each other
};

// A run's poses beside its reference.
struct AgainstReference {
  std::vector<Eigen::Vector3d> reference;  // in the trajectory's world
  std::vector<double> distance_m;
  std::vector<double> error_m;
};
// align: fitted rigidly; else first poses are put onto each other.
AgainstReference against_reference(const std::vector<PosePair>& pairs, bool align);

// The bytes of a picture of 1600 x 760 px.
Result<std::vector<unsigned char>> draw_plot(const RunPicture& run, PictureFormat format = PictureFormat::png);

}  // namespace cliquevo::tools
