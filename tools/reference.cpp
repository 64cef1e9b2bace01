// SPDX-License-Identifier: BSD-3-Clause
#include "tools/reference.h"

#include <filesystem>

#include <fmt/format.h>

namespace cliquevo::tools {

namespace fs = std::filesystem;

std::string reference_beside(const std::string& recording) {
  for (const char* name : {"poses.txt", "groundtruth.tum"}) {
    std::error_code ignored;
    if (const fs::path file = fs::path(recording) / name; fs::is_regular_file(file, ignored)) return file.string();
  }
  return "";
}

Result<RunReference> reference_from_file(const std::string& path, const std::vector<FrameRecord>& frames) {
  const auto trajectory = daemon::read_trajectory(path);
  if (!trajectory) return trajectory.error();
  RunReference out;
  out.name = path;
  if (trajectory->format == daemon::TrajectoryFormat::tum) {
    daemon::Trajectory estimate;
    estimate.format = daemon::TrajectoryFormat::tum;
    for (const FrameRecord& frame : frames) {
      estimate.poses.push_back({frame.estimate.stamp_ns, frame.estimate.T_world_camera});
    }
    auto pairs = associate(*trajectory, estimate, {});
    if (!pairs) return Error{pairs.error().what, path, pairs.error().remedy};
    out.pairs = std::move(*pairs);
    out.align = true;
    return out;
  }
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const auto line = static_cast<std::size_t>(frames[i].index);
    if (line >= trajectory->poses.size()) {
      return Error{"reference is too short", path,
                   fmt::format("it has {} poses, the run reaches pair {}: give the one of this recording",
                               trajectory->poses.size(), line)};
    }
    const vo::Estimate& estimate = frames[i].estimate;
    out.pairs.push_back({estimate.stamp_ns, i, trajectory->poses[line].T_world_camera, estimate.T_world_camera});
  }
  return out;
}

std::optional<RunReference> reference_from_truth(const std::vector<FrameRecord>& frames) {
  RunReference out;
  out.name = "the exact truth";
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!frames[i].truth_T_world_camera) return std::nullopt;
    const vo::Estimate& estimate = frames[i].estimate;
    out.pairs.push_back({estimate.stamp_ns, i, *frames[i].truth_T_world_camera, estimate.T_world_camera});
  }
  if (out.pairs.empty()) return std::nullopt;
  return out;
}

}  // namespace cliquevo::tools
