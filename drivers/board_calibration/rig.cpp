// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/board_calibration/rig.h"

#include <fmt/format.h>

namespace cliquevo::calibration {

Rig Rig::moved(const Eigen::Matrix<double, kShared, 1>& step) const {
  Rig out = *this;
  out.left += step.head<kMostLens>();
  out.right += step.segment<kMostLens>(kFirstOfRight);
  out.T_right_left = perturb_left(T_right_left, step.segment<6>(kFirstOfPose)).normalized();
  out.bend_m += step.tail<2>();
  return out;
}

StereoCalibration Rig::calibration() const {
  StereoCalibration out;
  out.left = to_camera(*model, left, width, height);
  out.right = to_camera(*model, right, width, height);
  out.T_right_left = T_right_left;
  return out;
}

std::string shared_name(const Rig& rig, int index) {
  static constexpr std::array<const char*, 8> kOthers{"tx_m",   "ty_m",   "tz_m",     "rx_rad",
                                                      "ry_rad", "rz_rad", "bend_x_m", "bend_y_m"};
  if (index < kFirstOfRight) return "left." + rig.model->parameter_name(index);
  if (index < kFirstOfPose) return "right." + rig.model->parameter_name(index - kFirstOfRight);
  return kOthers[static_cast<std::size_t>(index - kFirstOfPose)];
}

BentCorner bent_corner(const Board& board, int id, const Eigen::Vector2d& bend_m) {
  BentCorner out;
  out.at = board.corner(id);
  const Eigen::Vector2d half = board.half_extent().cwiseMax(1e-9);
  const Eigen::Vector2d place = (out.at.head<2>() - board.middle()).cwiseQuotient(half);
  out.height_by_bend = place.cwiseAbs2().transpose();
  out.at.z() = out.height_by_bend * bend_m;
  return out;
}

}  // namespace cliquevo::calibration
