// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/board_calibration/held_out.h"

#include <algorithm>
#include <cmath>

#include "stereo/camera_projection.h"
#include "stereo/rectification.h"

namespace cliquevo::calibration {

namespace {

constexpr std::size_t kFolds = 5;
constexpr double kLeastForward = 0.2;  // z of a unit direction: rectified images reach no farther

struct Rectifier {
  stereo::CameraProjection left;
  stereo::CameraProjection right;
  PrescribedRectification rectification;
};

std::optional<Rectifier> rectifier(const Rig& rig) {
  const StereoCalibration calibration = rig.calibration();
  const auto rectification = stereo::choose_rectification(calibration);
  if (!rectification) return std::nullopt;
  return Rectifier{stereo::CameraProjection(calibration.left), stereo::CameraProjection(calibration.right),
                   *rectification};
}

std::optional<double> row_of(const stereo::CameraProjection& camera, const Eigen::Matrix3d& R, const StereoModel& model,
                             const Eigen::Vector2d& px) {
  const auto direction = camera.direction(px.x(), px.y());
  if (!direction) return std::nullopt;
  const Eigen::Vector3d d = (R * *direction).normalized();
  if (d.z() < kLeastForward) return std::nullopt;
  return model.fy_px * d.y() / d.z() + model.cy_px;
}

std::vector<double> row_differences(const Rectifier& r, const View& view) {
  std::vector<double> out;
  for (const SeenCorner& left : view.left) {
    const auto right =
        std::find_if(view.right.begin(), view.right.end(), [&](const SeenCorner& c) { return c.id == left.id; });
    if (right == view.right.end()) continue;
    const auto left_row = row_of(r.left, r.rectification.R_left, r.rectification.model, left.px);
    const auto right_row = row_of(r.right, r.rectification.R_right, r.rectification.model, right->px);
    if (left_row && right_row) out.push_back(*left_row - *right_row);
  }
  return out;
}

}  // namespace

std::vector<double> row_differences(const Rig& rig, const View& view) {
  const auto r = rectifier(rig);
  return r ? row_differences(*r, view) : std::vector<double>{};
}

HeldOut hold_out(const Board& board, const Solution& solution, const AdjustmentOptions& options) {
  HeldOut out;
  double rows = 0.0;
  double row_count = 0.0;
  double squared = 0.0;
  double coordinates = 0.0;
  AdjustmentOptions poses_only = options;
  poses_only.estimated.fill(false);
  const std::size_t n = solution.views.size();
  for (std::size_t fold = 0; fold < std::min(kFolds, n); ++fold) {
    std::vector<View> kept, left_out;
    std::vector<RigidTransform> kept_poses, left_out_poses;
    for (std::size_t v = 0; v < n; ++v) {
      const bool out_of_it = v % kFolds == fold;
      (out_of_it ? left_out : kept).push_back(solution.views[v]);
      (out_of_it ? left_out_poses : kept_poses).push_back(solution.adjusted.T_left_board[v]);
    }
    if (kept.size() < 3 || left_out.empty()) continue;
    const Adjusted fitted = adjust(board, kept, solution.rig(), kept_poses, options);
    const Adjusted judged = adjust(board, left_out, fitted.rig, left_out_poses, poses_only);
    const auto r = rectifier(fitted.rig);
    for (std::size_t v = 0; v < left_out.size(); ++v) {
      for (const Side side : {Side::left, Side::right}) {
        for (const auto& e : residuals(board, fitted.rig, judged.T_left_board[v], left_out[v], side)) {
          if (!e.allFinite()) continue;
          squared += e.squaredNorm();
          coordinates += 2.0;
        }
      }
      if (!r) continue;
      for (const double difference : row_differences(*r, left_out[v])) {
        rows += difference * difference;
        row_count += 1.0;
      }
    }
  }
  out.corners = static_cast<int>(row_count);
  out.row_rms_px = row_count > 0.0 ? std::sqrt(rows / row_count) : 0.0;
  out.reprojection_rms_px = coordinates > 0.0 ? std::sqrt(squared / coordinates) : 0.0;
  return out;
}

}  // namespace cliquevo::calibration
