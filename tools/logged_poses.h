// SPDX-License-Identifier: BSD-3-Clause
// The odometry that a log holds beside its pairs.
#pragma once

#include <string>
#include <vector>

#include <cliquevo/odometry_t.hpp>
#include <cliquevo/pose_t.hpp>

namespace cliquevo::tools {

struct LoggedPoses {
  std::vector<odometry_t> odometry;  // VO_ODOMETRY
  std::vector<pose_t> poses;         // POSE_BODY, of logs that have no VO_ODOMETRY
};

// Of a log or a folder of such, by their exposure; nothing for any other source.
LoggedPoses read_logged_poses(const std::string& path);

}  // namespace cliquevo::tools
