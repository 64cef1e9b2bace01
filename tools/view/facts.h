// SPDX-License-Identifier: BSD-3-Clause
// What the page gets of a frame, from wherever it comes: the pipeline itself, or a daemon's messages. The room's
// only view of the odometry's types.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/base/camera_model.h"
#include "core/base/rigid_transform.h"
#include "core/vo/evidence.h"
#include "core/vo/movers.h"
#include "core/vo/seen_feature.h"
#include "core/vo/verdict.h"

namespace cliquevo::view {

// The page's world: X forward, Y left, Z up, origin where the vehicle started. Of a camera: Z forward, X right, Y down.
RigidTransform forward_left_up();

struct CheckFact {
  double ratio = 0.0;  // value over bound; above 1 fails, 0: did not apply
  std::optional<double> value;
  std::optional<double> bound;
};

struct MoverFact {
  std::int32_t id = 0;
  bool of_vehicle = false;
  Eigen::Vector3d centre_m = Eigen::Vector3d::Zero();  // camera's frame
  double speed_m_s = 0.0;
  double left_px = 0.0, top_px = 0.0, right_px = 0.0, bottom_px = 0.0;
};

struct Durations {
  std::int64_t rectify_us = 0, stereo_us = 0, odometry_us = 0;
  std::array<std::int64_t, 5> steps_us{};  // features, scores, matches, clique, motion
};

struct FrameFacts {
  std::int64_t index = 0;
  std::int64_t stamp_us = 0;
  std::int32_t epoch = 0;  // rises when the source begins anew: the way has a break there
  int status = 0;
  int quality = 0;
  RigidTransform T_world_body;                            // page's world; body: X forward, Y left, Z up
  Eigen::Matrix3d position_m2 = Eigen::Matrix3d::Zero();  // covariance of where it is, from the start on
  double step_sigma_m = 0.0;                              // of this frame's motion
  int features = 0, matches = 0, clique = 0, inliers = 0;
  double error_px = 0.0, expected_error_px = 0.0;
  double shift_px = 0.0;
  double disparity_offset_px = 0.0, disparity_offset_sigma_px = 0.0;
  double vertical_px = 0.0, vertical_sigma_px = 0.0;
  std::array<CheckFact, vo::kChecks> checks{};
  std::uint32_t failed = 0;  // mask of checks
  Durations times;
  std::int64_t latency_us = 0;             // 0: not measured
  std::optional<Eigen::Vector3d> truth_m;  // page's world
  std::vector<MoverFact> movers;
  std::vector<Eigen::Vector3f> points;  // of some features, page's world
};

// One line of JSON, keys as short as the page wants them (list: tools/view/page/record.js).
std::string to_json(const FrameFacts& facts, std::int64_t number);

// How uncertain the place has become since the start, from each motion's covariance.
class WayUncertainty {
 public:
  void restart() { *this = {}; }
  // The camera's place in the page's world, and the covariance of its motion since the last valid frame.
  Eigen::Matrix3d add(bool valid, const RigidTransform& T_world_camera, const Matrix6d& covariance);

 private:
  bool begun_ = false;
  RigidTransform T_world_valid_;
  Matrix6d sum_ = Matrix6d::Zero();
};

// Some of the inliers, spread over the list, as points of the page's world.
std::vector<Eigen::Vector3f> some_points(const std::vector<vo::SeenFeature>& features, std::size_t most,
                                         const StereoModel& model, const RigidTransform& T_world_camera);

}  // namespace cliquevo::view
