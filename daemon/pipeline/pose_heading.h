// SPDX-License-Identifier: BSD-3-Clause
// Tables of poses whose heading names their columns, in any order and spelling: "timestamp,x,y,z,qw,qx,qy,qz",
// "# id timestamp tx ty tz qx qy qz qw", "field.pose.pose.position.x", "p_RS_R_x [m]", "northing ... roll, pitch, yaw".
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "daemon/pipeline/pose_row.h"

namespace cliquevo::daemon {

struct PoseHeading {
  std::size_t columns = 0;  // words of every row
  bool w_first = false;     // of its quaternion
  RowReader reader;
};

// What a heading without its # says about rows like the one given, the first behind it. None: it names no position, so
// it says nothing about the order. `bare`: it was no comment, which may be prose. Error: it names a position but no
// orientation, a column twice, more or fewer columns than the row has, or motions instead of poses.
Result<std::optional<PoseHeading>> read_pose_heading(std::string_view heading, bool bare, const PoseRow& row);

}  // namespace cliquevo::daemon
