// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/pose_heading.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include <fmt/format.h>

#include "daemon/pipeline/pose_names.h"

namespace cliquevo::daemon {

namespace {

using Names = std::vector<ColumnName>;
using Column = std::optional<std::size_t>;

Column find(const Names& names, ColumnRole role) {
  const auto at =
      std::find_if(names.begin(), names.end(), [role](const ColumnName& name) { return name.role == role; });
  return at == names.end() ? Column{} : Column(static_cast<std::size_t>(at - names.begin()));
}

bool has(const Names& names, std::initializer_list<ColumnRole> roles) {
  return std::all_of(roles.begin(), roles.end(), [&](ColumnRole role) { return find(names, role).has_value(); });
}

bool has_part(const Names& names, std::string_view part) {
  return std::any_of(names.begin(), names.end(), [part](const ColumnName& name) {
    return std::find(name.parts.begin(), name.parts.end(), part) != name.parts.end();
  });
}

// How the orientation is written.
enum class Turn {
  quaternion,
  angles,         // axes of the body as they are
  angles_down,    // X forward, Y right, Z down
  angles_boreas,  // each angle in the other sense, and in the other order
};

struct Columns {
  std::array<std::size_t, 3> place{};
  std::array<double, 3> place_unit_m{};
  Turn turn = Turn::quaternion;
  std::array<std::size_t, 4> turns{};  // w x y z, or roll pitch yaw
  std::array<double, 3> turn_unit_rad{1.0, 1.0, 1.0};
};

using Roles = std::array<ColumnRole, 3>;

std::optional<Roles> place_roles(const Names& names) {
  using enum ColumnRole;
  for (const Roles& roles : {Roles{x, y, z}, Roles{north, east, down}, Roles{east, north, up}}) {
    if (has(names, {roles[0], roles[1], roles[2]})) return roles;
  }
  return std::nullopt;
}

double metres(const std::string& unit) { return unit == "mm" ? 1e-3 : unit == "cm" ? 1e-2 : 1.0; }

std::int64_t unit_ns(const std::string& unit) {
  if (unit == "ns" || unit == "nsec") return 1;
  if (unit == "us" || unit == "\xC2\xB5s" || unit == "\xCE\xBCs") return 1'000;
  return unit == "ms" ? 1'000'000 : 0;
}

// False: there is no orientation.
bool find_turn(const Names& names, Columns& out) {
  using enum ColumnRole;
  if (has(names, {qw, qx, qy, qz})) {
    out.turns = {*find(names, qw), *find(names, qx), *find(names, qy), *find(names, qz)};
    return true;
  }
  const ColumnRole about_z = has(names, {heading, east}) ? heading : yaw;
  if (!has(names, {roll, pitch, about_z})) return false;
  out.turns = {*find(names, roll), *find(names, pitch), *find(names, about_z), 0};
  for (std::size_t i = 0; i < 3; ++i) {
    const bool degrees = names[out.turns[i]].unit.rfind("deg", 0) == 0;
    out.turn_unit_rad[i] = degrees ? std::numbers::pi / 180.0 : 1.0;
  }
  out.turn = about_z == heading ? Turn::angles_boreas : has(names, {x}) ? Turn::angles : Turn::angles_down;
  return true;
}

Result<RigidTransform> read_row(const Columns& columns, const PoseRow& row) {
  std::array<double, 3> t{};
  for (std::size_t i = 0; i < t.size(); ++i) {
    const auto value = number_in(row, columns.place[i]);
    if (!value) return value.error();
    t[i] = *value * columns.place_unit_m[i];
  }
  std::array<double, 4> q{};
  for (std::size_t i = 0; i < (columns.turn == Turn::quaternion ? 4U : 3U); ++i) {
    const auto value = number_in(row, columns.turns[i]);
    if (!value) return value.error();
    q[i] = *value;
  }
  if (columns.turn == Turn::quaternion) return pose_of(row, t, q, "qx qy qz qw must be a unit quaternion");
  for (std::size_t i = 0; i < 3; ++i) {
    q[i] *= columns.turn_unit_rad[i];
    if (!(std::abs(q[i]) < 7.0))
      return bad_row(row, "an angle is more than a turn in radians: name its unit in the heading, as in 'yaw [deg]'");
  }
  const Eigen::Matrix3d R = rotation_of_angles(q[0], q[1], q[2]);
  const Eigen::Matrix3d turned = columns.turn == Turn::angles_boreas ? Eigen::Matrix3d(R.transpose())
                                 : columns.turn == Turn::angles_down ? Eigen::Matrix3d(R * down_to_up())
                                                                     : R;
  return RigidTransform{turned, {t[0], t[1], t[2]}};
}

// Whose poses they are, by names that only one kind of producer writes.
void find_body(const Names& names, Turn turn, std::string_view path, RowReader& reader) {
  const auto set = [&reader](const char* body, BodyMounting mounting) {
    reader.body = body;
    reader.mounting = mounting;
  };
  const bool biases = has_part(names, "bgx") || has_part(names, "bwx") || has_part(names, "bias");
  const std::string_view file = path.substr(path.find_last_of('/') + 1);
  if (has_part(names, "rs")) return set("the body (EuRoC)", BodyMounting::euroc);
  if (biases) return set("the IMU (its biases are beside them)", BodyMounting::euroc);
  if (has_part(names, "pr11")) return set("the IMU (OpenVINS)", BodyMounting::euroc);
  if (turn == Turn::angles_boreas && file.rfind("camera", 0) != 0)
    return set("another sensor (Boreas: camera_poses.csv has the camera's)", BodyMounting::unknown);
  if (turn == Turn::angles_down) return set("the navigation unit", BodyMounting::unknown);
  if (turn == Turn::angles) set("a vehicle (roll, pitch, yaw)", BodyMounting::unknown);
}

void find_time(const Names& names, RowReader& reader) {
  const Column time = find(names, ColumnRole::time);
  const Column part = find(names, ColumnRole::part);
  reader.stamp = time ? time : part;
  if (time && part && names[*time].unit != "ns") reader.nanoseconds = part;
  if (reader.stamp) reader.unit_ns = time ? unit_ns(names[*time].unit) : 1;
  if (!reader.stamp) reader.frame = find(names, ColumnRole::frame);
}

// A role that two columns have is nobody's to choose.
std::optional<std::string> named_twice(const Names& names, const Columns& columns) {
  const auto twice = [&](std::size_t column) -> std::optional<std::string> {
    for (std::size_t i = column + 1; i < names.size(); ++i) {
      if (names[i].role == names[column].role) return fmt::format("'{}' and '{}'", names[column].text, names[i].text);
    }
    return std::nullopt;
  };
  for (const std::size_t column : columns.place) {
    if (auto found = twice(column)) return found;
  }
  for (std::size_t i = 0; i < (columns.turn == Turn::quaternion ? 4U : 3U); ++i) {
    if (auto found = twice(columns.turns[i])) return found;
  }
  return std::nullopt;
}

// Words of prose around the names in a comment.
void leave_out_prose(Names& names, std::size_t columns) {
  while (names.size() > columns && names.front().role == ColumnRole::none) names.erase(names.begin());
  if (names.size() <= columns) return;
  const Names kept(names.begin(), names.begin() + static_cast<std::ptrdiff_t>(columns));
  Columns unused;
  if (place_roles(kept) && find_turn(kept, unused)) names = kept;
}

Error no_orientation(const PoseRow& row) {
  return bad_row(
      row,
      "the heading names a position but no orientation (qx qy qz qw, or roll pitch yaw): give poses, positions "
      "alone cannot be compared");
}

}  // namespace

Result<std::optional<PoseHeading>> read_pose_heading(std::string_view heading, bool bare, const PoseRow& row) {
  const std::size_t colon = bare ? std::string_view::npos : heading.rfind(": ");
  Names names = column_names(colon == std::string_view::npos ? heading : heading.substr(colon + 2));
  std::size_t words = row.words.size();
  while (words > names.size() && row.words[words - 1].empty()) --words;
  if (!bare) leave_out_prose(names, words);
  const auto place = place_roles(names);
  if (!place) return std::optional<PoseHeading>{};
  const auto is_other_time = [](const ColumnName& name) { return name.role == ColumnRole::other_time; };
  if (std::count_if(names.begin(), names.end(), is_other_time) == 2) {
    return bad_row(row, "its rows are motions from one time to another, not poses: chain them to poses first");
  }
  Columns columns;
  for (std::size_t i = 0; i < 3; ++i) {
    columns.place[i] = *find(names, (*place)[i]);
    columns.place_unit_m[i] = metres(names[columns.place[i]].unit);
  }
  if (!find_turn(names, columns)) {
    if (bare || names.size() == words) return no_orientation(row);
    return std::optional<PoseHeading>{};
  }
  if (names.size() != words)
    return bad_row(row, fmt::format("{} words where the heading names {} columns", words, names.size()));
  if (const auto twice = named_twice(names, columns)) {
    return bad_row(row, fmt::format("{} in the heading could both be meant: leave one column", shown(*twice)));
  }
  PoseHeading out;
  out.columns = names.size();
  out.w_first = columns.turn == Turn::quaternion && columns.turns[0] < columns.turns[1];
  out.reader.pose = [columns](const PoseRow& r) { return read_row(columns, r); };
  out.reader.child_frame = find(names, ColumnRole::child_frame);
  find_time(names, out.reader);
  find_body(names, columns.turn, row.path, out.reader);
  return std::optional(std::move(out));
}

}  // namespace cliquevo::daemon
