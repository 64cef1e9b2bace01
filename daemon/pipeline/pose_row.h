// SPDX-License-Identifier: BSD-3-Clause
// One row of a trajectory file, and how rows are read once their format is known. Used by the readers of such files.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/base/rigid_transform.h"
#include "daemon/pipeline/trajectory_file.h"

namespace cliquevo::daemon {

struct PoseRow {
  std::vector<std::string_view> words;
  bool commas = false;  // part the words
  std::string_view path;
  int line = 0;
};

// What a format (or a heading) says about every row. Columns count from 0.
struct RowReader {
  std::function<Result<RigidTransform>(const PoseRow&)> pose;  // the numbers as they are, whatever their axes
  std::optional<std::size_t> stamp;
  std::optional<std::size_t> nanoseconds;  // `stamp` are whole seconds then
  std::optional<std::size_t> frame;        // its number, where there is no stamp
  std::int64_t unit_ns = 0;                // of the stamps, where it is known; 0 = by the rule for recordings' stamps
  std::optional<std::size_t> child_frame;  // a frame's name: nav_msgs/Odometry
  const char* body = nullptr;              // whose poses they are; nullptr = the camera's, or not known
  BodyMounting mounting = BodyMounting::unknown;
  const char* note = nullptr;
};

// Words between blanks, and between commas or semicolons; `keep_empty`: those between two of the latter, too.
std::vector<std::string_view> split_row(std::string_view text, bool keep_empty);

Error bad_row(const PoseRow& row, std::string remedy);
// A word for a message, whatever is in it.
std::string shown(std::string_view word);
// The number in a column; the error names the word.
Result<double> number_in(const PoseRow& row, std::size_t column);
// w, x, y, z of about unit length; the error is `complaint`.
Result<RigidTransform> pose_of(const PoseRow& row, const std::array<double, 3>& t, const std::array<double, 4>& q,
                               const char* complaint);
// About x, then y, then z, each by the axes of the world: Rz(yaw) Ry(pitch) Rx(roll).
Eigen::Matrix3d rotation_of_angles(double roll, double pitch, double yaw);
// From axes X forward, Y right, Z down to X forward, Y left, Z up.
Eigen::Matrix3d down_to_up();

}  // namespace cliquevo::daemon
