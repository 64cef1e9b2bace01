// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/pose_kinds.h"

#include <array>
#include <cmath>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "drivers/text_file.h"

namespace cliquevo::daemon {

namespace {

bool is_whole(std::string_view word, std::size_t least_digits) {
  return word.size() >= least_digits && word.find_first_not_of("0123456789") == std::string_view::npos;
}

bool has_ns(const PoseRow& row) { return is_whole(row.words[0], 16); }
bool has_epoch(const PoseRow& row) { return is_whole(row.words[0], 12); }

Result<RigidTransform> matrix_from(const PoseRow& row, std::size_t first) {
  std::array<double, 12> v{};
  for (std::size_t i = 0; i < v.size(); ++i) {
    const auto value = number_in(row, first + i);
    if (!value) return value.error();
    v[i] = *value;
  }
  RigidTransform T;
  T.R << v[0], v[1], v[2], v[4], v[5], v[6], v[8], v[9], v[10];
  T.t << v[3], v[7], v[11];
  if (!((T.R * T.R.transpose() - Eigen::Matrix3d::Identity()).norm() <= 0.01) || T.R.determinant() < 0.0) {
    return bad_row(row, fmt::format("columns {}-{}, {}-{} and {}-{} must be a rotation matrix", first + 1, first + 3,
                                    first + 5, first + 7, first + 9, first + 11));
  }
  return T;
}

// Position, then a quaternion.
Result<RigidTransform> quaternion_from(const PoseRow& row, std::size_t first, bool w_first) {
  std::array<double, 7> v{};
  for (std::size_t i = 0; i < v.size(); ++i) {
    const auto value = number_in(row, first + i);
    if (!value) return value.error();
    v[i] = *value;
  }
  if (w_first)
    return pose_of(row, {v[0], v[1], v[2]}, {v[3], v[4], v[5], v[6]}, "columns 5-8 must be a unit quaternion, w first");
  return pose_of(row, {v[0], v[1], v[2]}, {v[6], v[3], v[4], v[5]}, "qx qy qz qw must be a unit quaternion");
}

Result<RigidTransform> kitti_pose(const PoseRow& row) { return matrix_from(row, 0); }
Result<RigidTransform> matrix_after_first(const PoseRow& row) { return matrix_from(row, 1); }
Result<RigidTransform> tum_pose(const PoseRow& row) { return quaternion_from(row, 1, false); }
Result<RigidTransform> euroc_pose(const PoseRow& row) { return quaternion_from(row, 1, true); }

// The camera's axes are X forward, Y right, Z down there: to X right, Y down, Z forward.
Result<RigidTransform> tartanair_pose(const PoseRow& row) {
  auto T = quaternion_from(row, 0, false);
  if (!T) return T;
  Eigen::Matrix3d to_optical;
  to_optical << 0, 0, 1, 1, 0, 0, 0, 1, 0;
  return RigidTransform{T->R * to_optical, T->t};
}

// The vehicle's axes are X forward, Y right, Z down there.
Result<RigidTransform> nclt_pose(const PoseRow& row) {
  std::array<double, 6> v{};
  for (std::size_t i = 0; i < v.size(); ++i) {
    const auto value = number_in(row, 1 + i);
    if (!value) return value.error();
    v[i] = *value;
  }
  if (!(std::abs(v[3]) < 7.0 && std::abs(v[4]) < 7.0 && std::abs(v[5]) < 7.0))
    return bad_row(row, "columns 5-7 must be roll, pitch and yaw in radians");
  return RigidTransform{rotation_of_angles(v[3], v[4], v[5]) * down_to_up(), {v[0], v[1], v[2]}};
}

template <std::size_t count>
bool has_words(const PoseRow& row) {
  return row.words.size() == count;
}

bool is_vins(const PoseRow& row) {
  return (row.words.size() == 11 || row.words.size() == 12) && row.commas && has_ns(row);
}

bool is_short_euroc(const PoseRow& row) { return row.words.size() == 8 && row.commas && has_ns(row); }

bool is_kitti360(const PoseRow& row) {
  return row.words.size() == 17 && !has_ns(row) && drivers::parse_number(row.words[16]) == 1.0;
}

bool is_kaist(const PoseRow& row) { return row.words.size() == 13 && has_ns(row); }
bool is_nclt(const PoseRow& row) { return row.words.size() == 7 && has_epoch(row); }

using PoseFunction = Result<RigidTransform> (*)(const PoseRow&);

RowReader a_row_a_frame(PoseFunction pose, const char* note = nullptr) {
  RowReader out;
  out.pose = pose;
  out.note = note;
  return out;
}

// unit_ns 0: by the stamps' magnitude.
RowReader stamped(PoseFunction pose, std::int64_t unit_ns, const char* body = nullptr,
                  BodyMounting mounting = BodyMounting::unknown) {
  RowReader out;
  out.pose = pose;
  out.stamp = 0;
  out.unit_ns = unit_ns;
  out.body = body;
  out.mounting = mounting;
  return out;
}

RowReader numbered(PoseFunction pose, const char* body = nullptr, BodyMounting mounting = BodyMounting::unknown) {
  RowReader out = stamped(pose, 0, body, mounting);
  out.frame = std::exchange(out.stamp, std::nullopt);
  return out;
}

// A row a format, in the order in which they are tried.
const std::vector<PoseKind>& pose_kinds() {
  static const std::vector<PoseKind> kinds{
      {"VINS-Fusion", "11", is_vins, stamped(euroc_pose, 1, "the IMU (VINS-Fusion)", BodyMounting::euroc)},
      {"KITTI", "12", has_words<12>, a_row_a_frame(kitti_pose)},
      {"EuRoC in short", "8 with ns and commas", is_short_euroc,
       stamped(euroc_pose, 1, "the body (EuRoC)", BodyMounting::euroc)},
      {"TUM", "8", has_words<8>, stamped(tum_pose, 0)},
      {"KITTI-360's cam0_to_world.txt", "17", is_kitti360, numbered(matrix_after_first)},
      {"EuRoC", "17", has_words<17>, stamped(euroc_pose, 1, "the body (EuRoC)", BodyMounting::euroc)},
      {"KAIST Urban", "13 with ns", is_kaist, stamped(matrix_after_first, 1, "the vehicle (KAIST Urban)")},
      {"KITTI-360's poses.txt", "13", has_words<13>,
       numbered(matrix_after_first, "the vehicle (KITTI-360)", BodyMounting::kitti360)},
      {"NCLT", "7 with a stamp", is_nclt, stamped(nclt_pose, 0, "the vehicle (NCLT)")},
      {"TartanAir", "7", has_words<7>,
       a_row_a_frame(tartanair_pose,
                     "7 numbers a row are taken for TartanAir's: a row a frame, the camera's axes X "
                     "forward, Y right, Z down")}};
  return kinds;
}

}  // namespace

const PoseKind* pose_kind_of(const PoseRow& row) {
  for (const PoseKind& kind : pose_kinds()) {
    if (kind.fits(row)) return &kind;
  }
  return nullptr;
}

std::string known_pose_kinds() {
  std::string out;
  for (const PoseKind& kind : pose_kinds())
    fmt::format_to(std::back_inserter(out), "{}{} ({})", out.empty() ? "" : ", ", kind.words, kind.name);
  return out;
}

}  // namespace cliquevo::daemon
