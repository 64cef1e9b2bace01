// SPDX-License-Identifier: BSD-3-Clause
// The names in the heading of a table of poses, and what each is of.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace cliquevo::daemon {

enum class ColumnRole {
  none,  // velocities, biases, covariances, what is not known
  time,
  part,  // nanoseconds beside whole seconds
  frame,
  other_time,  // of a motion from one time to another
  child_frame,
  x,
  y,
  z,
  qw,
  qx,
  qy,
  qz,
  roll,
  pitch,
  yaw,
  heading,
  north,
  east,
  down,
  up,
};

struct ColumnName {
  std::string text;                // as it stands there, without what is in brackets
  std::vector<std::string> parts;  // "p_RS_R_x", "positionX" -> p rs r x, position x
  std::string unit;                // "ns" of "timestamp [ns]", "t(ns)" or "time_ns"; may be empty
  ColumnRole role = ColumnRole::none;
};

// A heading without its # or %: names between semicolons, commas or blanks, whichever it has.
std::vector<ColumnName> column_names(std::string_view heading);

}  // namespace cliquevo::daemon
