// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluation.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace cliquevo::tools {

namespace {

using daemon::StampedPose;
using daemon::Trajectory;
using daemon::TrajectoryFormat;

constexpr double kDegree = 180.0 / std::numbers::pi;

// Angle by the trace, as KITTI's tools have it: rotations read from rounded text are not quite orthonormal, and other
// formulas would answer differently.
double angle_by_trace(const Eigen::Matrix3d& R) { return std::acos(std::clamp((R.trace() - 1.0) / 2.0, -1.0, 1.0)); }

// (estimate's motion)^-1 * (reference's motion) between two pairs.
RigidTransform motion_error(const PosePair& from, const PosePair& to) {
  return (from.estimate.inverse() * to.estimate).inverse() * (from.reference.inverse() * to.reference);
}

std::vector<PosePair> associate_by_line(const Trajectory& reference, const Trajectory& estimate) {
  std::vector<PosePair> pairs(std::min(reference.poses.size(), estimate.poses.size()));
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    pairs[i] = {0, i, reference.poses[i].T_world_camera, estimate.poses[i].T_world_camera};
  }
  return pairs;
}

// Line i of the estimate is frame i.
std::vector<PosePair> associate_by_number(const Trajectory& reference, const Trajectory& estimate) {
  std::vector<PosePair> pairs;
  for (const StampedPose& pose : reference.poses) {
    const auto line = static_cast<std::size_t>(pose.frame);
    if (line >= estimate.poses.size()) break;
    pairs.push_back({0, line, pose.T_world_camera, estimate.poses[line].T_world_camera});
  }
  return pairs;
}

std::size_t nearest(const std::vector<StampedPose>& poses, TimestampNs stamp_ns) {
  const auto after = std::lower_bound(poses.begin(), poses.end(), stamp_ns,
                                      [](const StampedPose& pose, TimestampNs stamp) { return pose.stamp_ns < stamp; });
  if (after == poses.begin()) return 0;
  const auto before = std::prev(after);
  const bool take_after = after != poses.end() && after->stamp_ns - stamp_ns < stamp_ns - before->stamp_ns;
  return static_cast<std::size_t>((take_after ? after : before) - poses.begin());
}

std::vector<PosePair> associate_by_stamp(const Trajectory& reference, const Trajectory& estimate,
                                         std::int64_t max_difference_ns) {
  std::vector<PosePair> pairs;
  std::size_t last_used = 0;
  std::int64_t last_difference = 0;
  for (std::size_t i = 0; i < estimate.poses.size(); ++i) {
    const StampedPose& pose = estimate.poses[i];
    const std::size_t j = nearest(reference.poses, pose.stamp_ns);
    const std::int64_t difference = std::abs(reference.poses[j].stamp_ns - pose.stamp_ns);
    if (difference > max_difference_ns) continue;
    // A reference pose serves one estimate: the nearest.
    if (!pairs.empty() && j == last_used) {
      if (difference >= last_difference) continue;
      pairs.pop_back();
    }
    pairs.push_back({pose.stamp_ns, i, reference.poses[j].T_world_camera, pose.T_world_camera});
    last_used = j;
    last_difference = difference;
  }
  return pairs;
}

// The same motion described in camera axes: x = -y, y = -z, z = x.
void turn_body_to_camera(std::vector<PosePair>& pairs) {
  RigidTransform T_camera_body;
  T_camera_body.R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  for (PosePair& pair : pairs) pair.reference = T_camera_body * pair.reference * T_camera_body.inverse();
}

void measure_segments(const std::vector<PosePair>& pairs, const std::vector<double>& distance_m,
                      const EvaluationOptions& options, Evaluation& out) {
  for (const double length : options.lengths_m) out.by_length.push_back({length, 0, 0.0, 0.0});
  double t_sum = 0.0;
  double r_sum = 0.0;
  for (std::size_t first = 0; first < pairs.size(); ++first) {
    for (LengthError& entry : out.by_length) {
      const auto end = std::upper_bound(distance_m.begin() + static_cast<std::ptrdiff_t>(first), distance_m.end(),
                                        distance_m[first] + entry.length_m);
      if (end == distance_m.end()) continue;
      const RigidTransform error =
          motion_error(pairs[first], pairs[static_cast<std::size_t>(end - distance_m.begin())]);
      const double t_error = error.t.norm() / entry.length_m;
      const double r_error = angle_by_trace(error.R) / entry.length_m;
      t_sum += t_error;
      r_sum += r_error;
      entry.t_err_pct += t_error;
      entry.r_err_deg_m += r_error;
      ++entry.segments;
      ++out.segments;
    }
  }
  for (LengthError& entry : out.by_length) {
    if (entry.segments == 0) continue;
    entry.t_err_pct *= 100.0 / entry.segments;
    entry.r_err_deg_m *= kDegree / entry.segments;
  }
  if (out.segments > 0) {
    out.t_err_pct = 100.0 * t_sum / out.segments;
    out.r_err_deg_m = kDegree * r_sum / out.segments;
  }
}

void measure_steps(const std::vector<PosePair>& pairs, Evaluation& out) {
  double t_squares = 0.0;
  double r_squares = 0.0;
  for (std::size_t i = 0; i + 1 < pairs.size(); ++i) {
    const RigidTransform error = motion_error(pairs[i], pairs[i + 1]);
    t_squares += error.t.squaredNorm();
    r_squares += std::pow(kDegree * error.angle(), 2);
    out.path_estimate_m += (pairs[i].estimate.inverse() * pairs[i + 1].estimate).t.norm();
  }
  const double steps = static_cast<double>(std::max<std::size_t>(1, pairs.size() - 1));
  out.rpe_m = std::sqrt(t_squares / steps);
  out.rpe_deg = std::sqrt(r_squares / steps);
}

void measure_absolute(const std::vector<PosePair>& pairs, Evaluation& out) {
  std::vector<Eigen::Vector3d> points;
  std::vector<Eigen::Vector3d> targets;
  for (const PosePair& pair : pairs) {
    points.push_back(pair.estimate.t);
    targets.push_back(pair.reference.t);
  }
  out.T_reference_estimate = align_rigid(points, targets);
  double squares = 0.0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double error = (out.T_reference_estimate * points[i] - targets[i]).norm();
    squares += error * error;
    out.ate_max_m = std::max(out.ate_max_m, error);
  }
  out.ate_m = std::sqrt(squares / static_cast<double>(points.size()));
}

void measure_sampled_paths(const std::vector<PosePair>& pairs, double period_s, Evaluation& out) {
  // Half a microsecond of slack: stamps are rounded in files.
  const auto period_ns = std::llround(period_s * 1e9) - 500;
  double reference = 0.0;
  double estimate = 0.0;
  const PosePair* last = &pairs.front();
  for (const PosePair& pair : pairs) {
    if (pair.stamp_ns - last->stamp_ns < period_ns && &pair != &pairs.back()) continue;
    reference += (pair.reference.t - last->reference.t).norm();
    estimate += (pair.estimate.t - last->estimate.t).norm();
    last = &pair;
  }
  out.sampled_path_m = reference;
  out.sampled_path_estimate_m = estimate;
}

}  // namespace

RigidTransform align_rigid(const std::vector<Eigen::Vector3d>& points, const std::vector<Eigen::Vector3d>& targets) {
  Eigen::Matrix3Xd from(3, points.size());
  Eigen::Matrix3Xd to(3, targets.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    from.col(static_cast<Eigen::Index>(i)) = points[i];
    to.col(static_cast<Eigen::Index>(i)) = targets[i];
  }
  const Eigen::Matrix4d T = Eigen::umeyama(from, to, false);
  return {T.topLeftCorner<3, 3>(), T.topRightCorner<3, 1>()};
}

std::vector<double> distances_m(const std::vector<PosePair>& pairs) {
  std::vector<double> distance_m(pairs.size(), 0.0);
  for (std::size_t i = 1; i < pairs.size(); ++i) {
    distance_m[i] = distance_m[i - 1] + (pairs[i].reference.t - pairs[i - 1].reference.t).norm();
  }
  return distance_m;
}

Result<std::vector<PosePair>> associate(const Trajectory& reference, const Trajectory& estimate,
                                        const EvaluationOptions& options) {
  if (reference.format != estimate.format) {
    return Error{"cannot compare trajectories",
                 reference.format == TrajectoryFormat::tum ? "the reference has stamps, the estimate is a row a frame"
                                                           : "the reference is a row a frame, the estimate has stamps",
                 "KITTI files carry no times: give both in one format (cliquevo replay --format)"};
  }
  std::vector<PosePair> pairs;
  if (reference.numbered) {
    pairs = associate_by_number(reference, estimate);
  } else if (reference.format == TrajectoryFormat::kitti) {
    pairs = associate_by_line(reference, estimate);
  } else {
    pairs = associate_by_stamp(reference, estimate, options.max_stamp_difference_ns);
  }
  if (pairs.size() < 2) {
    return Error{"cannot compare trajectories", fmt::format("{} poses belong together", pairs.size()),
                 fmt::format("two are needed: are the stamps of one clock, within {} ms of each other?",
                             options.max_stamp_difference_ns / 1'000'000)};
  }
  if (options.reference_frame == ReferenceFrame::body) turn_body_to_camera(pairs);
  return pairs;
}

Evaluation evaluate(const std::vector<PosePair>& pairs, const EvaluationOptions& options) {
  Evaluation out;
  out.frames_reference = out.frames_estimate = out.frames_compared = pairs.size();
  if (pairs.empty()) return out;
  const std::vector<double> distance_m = distances_m(pairs);
  out.path_m = distance_m.back();
  measure_segments(pairs, distance_m, options, out);
  measure_steps(pairs, out);
  measure_absolute(pairs, out);
  if (options.sample_period_s > 0.0) measure_sampled_paths(pairs, options.sample_period_s, out);
  const RigidTransform end = motion_error(pairs.front(), pairs.back());
  out.end_m = end.t.norm();
  out.end_deg = kDegree * end.angle();
  if (out.path_m > 0.0) out.end_pct = 100.0 * out.end_m / out.path_m;
  return out;
}

}  // namespace cliquevo::tools
