// SPDX-License-Identifier: BSD-3-Clause
// How far an estimated trajectory is from its reference: KITTI segment errors, absolute and relative pose errors,
// drift.
#pragma once

#include <optional>
#include <vector>

#include "core/base/result.h"
#include "core/base/rigid_transform.h"
#include "daemon/pipeline/trajectory_file.h"

namespace cliquevo::tools {

// In which frame the reference's poses are.
enum class ReferenceFrame {
  camera,  // Z forward, X right, Y down
  body,    // X forward, Y left, Z up (ROS): turned into camera frames before anything is compared
};

struct EvaluationOptions {
  std::vector<double> lengths_m = {10, 20, 40, 60, 80, 100};  // of the segments
  std::int64_t max_stamp_difference_ns = 10'000'000;          // between poses that belong together (TUM)
  double sample_period_s = 0.0;  // also measure both paths over poses at least this far apart (TUM), 0 = do not
  ReferenceFrame reference_frame = ReferenceFrame::camera;
};

// Two poses of the same instant.
struct PosePair {
  TimestampNs stamp_ns = 0;
  std::size_t estimate_index = 0;  // in its file
  RigidTransform reference;
  RigidTransform estimate;
};

struct LengthError {
  double length_m = 0.0;
  int segments = 0;
  double t_err_pct = 0.0;
  double r_err_deg_m = 0.0;
};

// Absent where there is nothing to average (a path shorter than every length, a reference that stands still).
struct Evaluation {
  std::size_t frames_reference = 0;
  std::size_t frames_estimate = 0;
  std::size_t frames_compared = 0;
  double path_m = 0.0;
  double path_estimate_m = 0.0;
  std::optional<double> sampled_path_m;
  std::optional<double> sampled_path_estimate_m;

  // Means over segments of each length from every start frame; equal weight to each segment.
  int segments = 0;
  std::optional<double> t_err_pct;
  std::optional<double> r_err_deg_m;
  std::vector<LengthError> by_length;

  // Positions after the rigid alignment (no scale) that makes them fit best.
  double ate_m = 0.0;  // root mean square
  double ate_max_m = 0.0;
  RigidTransform T_reference_estimate;  // that alignment

  // Frame to frame, root mean square.
  double rpe_m = 0.0;
  double rpe_deg = 0.0;

  // Of the last pose in the first one's frame.
  double end_m = 0.0;
  double end_deg = 0.0;
  std::optional<double> end_pct;
};

// Which poses belong together: by line in KITTI files (the shorter file decides), by nearest stamp in TUM files. Fails
// when the formats differ or fewer than two poses match.
Result<std::vector<PosePair>> associate(const daemon::Trajectory& reference, const daemon::Trajectory& estimate,
                                        const EvaluationOptions& options);

Evaluation evaluate(const std::vector<PosePair>& pairs, const EvaluationOptions& options);

// Way along the reference up to each pair, m.
std::vector<double> distances_m(const std::vector<PosePair>& pairs);

// Best rigid transform (no scale) from points to targets, least squares (Kabsch/Umeyama).
RigidTransform align_rigid(const std::vector<Eigen::Vector3d>& points, const std::vector<Eigen::Vector3d>& targets);

}  // namespace cliquevo::tools
