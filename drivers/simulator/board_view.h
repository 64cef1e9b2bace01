// SPDX-License-Identifier: BSD-3-Clause
// The board and a wall behind it as one camera sees them, ray by ray through its lens.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "core/base/image.h"
#include "core/base/rigid_transform.h"
#include "drivers/simulator/board_pattern.h"
#include "drivers/simulator/board_rig.h"

namespace cliquevo::drivers::sim {

// Pose of the board in this camera, seconds after the middle of the exposure.
using PoseAt = std::function<RigidTransform(double later_s)>;

class BoardView {
 public:
  // T_left_camera: where this camera is; the wall is round the left one.
  BoardView(const BoardPattern& pattern, const CameraCalibration& camera, const RigidTransform& T_left_camera,
            std::uint64_t seed);

  struct Shutter {
    double exposure_s = 0.0;
    double readout_s = 0.0;  // from the first row to the last
  };
  // Grey levels in sixteenths.
  void render(const PoseAt& T_camera_board, const Shutter& shutter, Image<std::uint16_t>& out) const;

 private:
  static constexpr int kSlices = 4;  // of the exposure
  struct Span {
    int i0 = 0, i1 = 0, j0 = 0, j1 = 0;  // i1, j1 excluded
  };
  // From a ray to a place on the board: x, y, 1 over the distance.
  using RayToBoard = Eigen::Matrix3d;
  struct Row {
    std::array<RayToBoard, kSlices> to_board;
    double light = 1.0;
  };
  Row row_at(const PoseAt& T_camera_board, const Shutter& shutter, int j) const;
  Span touched(const PoseAt& T_camera_board, const Shutter& shutter) const;
  float pixel(const Row& row, int i, int j) const;
  float ink(const Row& row, int slice, const Eigen::Vector3d& ray, float behind) const;
  const Eigen::Vector3d& ray(int i, int j) const {
    return rays_[static_cast<std::size_t>(j) * static_cast<std::size_t>(lens_.camera().width) +
                 static_cast<std::size_t>(i)];
  }
  Eigen::Vector3d across(int i, int j) const;  // of a ray, from column to column
  Eigen::Vector3d down(int i, int j) const;

  const BoardPattern& pattern_;
  SimulatedLens lens_;
  std::vector<Eigen::Vector3d> rays_;  // of each pixel; NaN where the lens shows nothing
  Image<std::uint16_t> wall_;
};

// Distance along a ray from a point to the wall, a sphere round the left camera, m.
double to_wall(const Eigen::Vector3d& from, const Eigen::Vector3d& ray);

}  // namespace cliquevo::drivers::sim
