// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/calibration/keyed_pose.h"

#include <cmath>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

#include "drivers/calibration/keyed_parts.h"
#include "drivers/text_file.h"

namespace cliquevo::drivers {

namespace {

// A quaternion's order shows by its real part, which is next to 1 between the cameras of a pair.
Result<Eigen::Matrix3d> rotation_of_quaternion(const std::vector<double>& q, const std::string& where) {
  constexpr double kMostlyReal = 0.9;
  const bool real_first = std::abs(q[0]) > kMostlyReal;
  if (real_first == (std::abs(q[3]) > kMostlyReal)) {
    return Error{"quaternion of unknown order: real part first or last", where, "give the rotation as a matrix"};
  }
  const Eigen::Quaterniond turn =
      real_first ? Eigen::Quaterniond(q[0], q[1], q[2], q[3]) : Eigen::Quaterniond(q[3], q[0], q[1], q[2]);
  if (std::abs(turn.norm() - 1.0) > 0.01) return calibration_error("quaternion is not of length 1", where);
  return Eigen::Matrix3d(turn.normalized().toRotationMatrix());
}

Result<Eigen::Matrix3d> rotation_of(const KeyEntry& R) {
  if (R.numbers.size() == 4) return rotation_of_quaternion(R.numbers, R.where);
  if (R.numbers.size() == 3) {  // as a rotation vector
    const Eigen::Vector3d turn(R.numbers[0], R.numbers[1], R.numbers[2]);
    if (turn.norm() > 4.0) return calibration_error("rotation vector is absurd", R.where);
    return Eigen::Matrix3d(so3_exp(turn));
  }
  const Eigen::Matrix3d out = matrix3_from(R.numbers);
  if (auto ok = check_rotation(out, R.where); !ok) return ok.error();
  return out;
}

// A pose between the cameras whose direction its name leaves open: the right camera lies on the right.
RigidTransform right_from_left(const RigidTransform& T) { return T.t.x() > 0.0 ? T.inverse() : T; }

// "T_c1_c2" takes points from camera 2 to camera 1, by the common convention; a word where the numbers say otherwise.
std::string note_on_direction(const KeyEntry& entry, const RigidTransform& T) {
  const std::string name = entry.key.substr(entry.key.rfind('.') + 1);
  const std::size_t first = name.find_first_of("0123456789");
  const std::size_t second = name.find_last_of("0123456789");
  const bool transform = name.starts_with("T") && name.find("to") == std::string::npos;
  if (!transform || first == std::string::npos || second == first) return {};
  const bool right_to_left = name[first] < name[second];
  if (right_to_left == (T.t.x() > 0.0)) return {};
  return fmt::format("{} leads the other way than its name says: otherwise the right camera would lie on the left",
                     printable(entry.key.substr(0, 64)));
}

using Pose = std::optional<KeyedPose>;

// The rotation between cameras whose rectifications are known: where they make the translation a baseline.
std::optional<Eigen::Matrix3d> rotation_by_rectification(const CameraParts& left, const CameraParts& right,
                                                         const Eigen::Vector3d& T) {
  if (!left.R || !right.R) return std::nullopt;
  const Eigen::Vector3d shift = *right.R * T;
  if (std::hypot(shift.y(), shift.z()) > 0.02 * T.norm()) return std::nullopt;
  return right.R->transpose() * *left.R;
}

// One rotation and translation for the pair, or the right camera's of two.
Result<Pose> pose_of_side(const Keys& keys, KeySide side, const KeyEntry& T, const CameraParts& left,
                          const CameraParts& right) {
  const Eigen::Vector3d t(T.numbers[0], T.numbers[1], T.numbers[2]);
  const auto R = keys.find(Quantity::rotation, side);
  if (!R) return R.error();
  if (*R == nullptr) {
    if (const auto rotation = rotation_by_rectification(left, right, t)) return Pose{{{*rotation, t}, false, {}}};
    return Error{"calibration lacks R, the rotation between the cameras", T.where, "name it R"};
  }
  const auto rotation = rotation_of(**R);
  if (!rotation) return rotation.error();
  const bool transposed = left.transposed && right.transposed && (*R)->numbers.size() == 9;
  return Pose{{{transposed ? Eigen::Matrix3d(rotation->transpose()) : *rotation, t}, false, {}}};
}

// Rotation and translation of one camera against a common frame; nothing = not there.
Result<std::optional<RigidTransform>> own_pose(const Keys& keys, Quantity rotation, Quantity translation,
                                               KeySide side) {
  const auto R = keys.find(rotation, side);
  if (!R) return R.error();
  const auto T = keys.find(translation, side);
  if (!T) return T.error();
  if (*T == nullptr) return std::optional<RigidTransform>{};
  if (*R == nullptr) {
    return Error{fmt::format("calibration lacks the {} camera's rotation", side == KeySide::left ? "left" : "right"),
                 (*T)->where, "add it"};
  }
  const auto matrix = rotation_of(**R);
  if (!matrix) return matrix.error();
  const std::vector<double>& t = (*T)->numbers;
  return std::optional{RigidTransform{*matrix, {t[0], t[1], t[2]}}};
}

// Each camera's own pose: from a common frame to the camera, or the other way round.
Result<Pose> pose_of_two(const Keys& keys) {
  for (const bool outwards : {false, true}) {
    const Quantity rotation = outwards ? Quantity::rotation_outwards : Quantity::rotation;
    const Quantity translation = outwards ? Quantity::translation_outwards : Quantity::translation;
    if (!keys.has(translation, KeySide::left) || !keys.has(translation, KeySide::right)) continue;
    const auto left = own_pose(keys, rotation, translation, KeySide::left);
    if (!left) return left.error();
    const auto right = own_pose(keys, rotation, translation, KeySide::right);
    if (!right) return right.error();
    if (outwards) return Pose{{(*right)->inverse() * **left, true, {}}};
    return Pose{{**right * (*left)->inverse(), false, {}}};
  }
  return Pose{};
}

Result<Pose> pose_of_matrices(const Keys& keys, const CameraParts& left, const CameraParts& right) {
  for (const KeySide side : {KeySide::none, KeySide::both, KeySide::right}) {
    const auto T = keys.find(Quantity::translation, side);
    if (!T) return T.error();
    if (*T == nullptr) continue;
    if (side == KeySide::right && keys.has(Quantity::translation, KeySide::left)) break;
    auto pose = pose_of_side(keys, side, **T, left, right);
    if (pose && *pose && side == KeySide::both) (*pose)->T_right_left = right_from_left((*pose)->T_right_left);
    return pose;
  }
  return pose_of_two(keys);
}

Result<Pose> pose_of_transforms(const Keys& keys) {
  for (const KeySide side : {KeySide::both, KeySide::none, KeySide::right}) {
    const auto entry = keys.find(Quantity::pose, side);
    if (!entry) return entry.error();
    if (*entry == nullptr || (side == KeySide::none && (*entry)->meaning.against_body)) continue;
    const auto T = transform_from((*entry)->numbers, (*entry)->where);
    if (!T) return T.error();
    if (side != KeySide::right) return Pose{{right_from_left(*T), false, note_on_direction(**entry, *T)}};
    const auto other = keys.find(Quantity::pose, KeySide::left);
    if (!other) return other.error();
    if (*other == nullptr) {
      if ((*entry)->meaning.against_body) continue;
      return Pose{{right_from_left(*T), false, {}}};
    }
    const auto T_left = transform_from((*other)->numbers, (*other)->where);
    if (!T_left) return T_left.error();
    // Unnamed frames: of the two readings the one with the right camera farther on the right.
    const RigidTransform to_body = T->inverse() * *T_left;
    const RigidTransform from_body = *T * T_left->inverse();
    if ((*entry)->meaning.against_body) {
      const bool to = (*entry)->meaning.body_first;
      const RigidTransform& T_right_left = to ? to_body : from_body;
      std::string note;
      if (T_right_left.t.x() > 0.0) {
        note = fmt::format("{} is read as leading {}, as its name says", printable((*entry)->key.substr(0, 64)),
                           to ? "from the camera to the frame of both" : "from the frame of both to the camera");
      }
      return Pose{{T_right_left, true, std::move(note)}};
    }
    return Pose{{from_body.t.x() < to_body.t.x() ? from_body : to_body, false,
                 fmt::format("{} and the other camera's name no direction: read so that the right camera lies on the "
                             "right",
                             printable((*entry)->key.substr(0, 64)))}};
  }
  return Pose{};
}

const KeyEntry* first_of(const Keys& keys, Quantity quantity) {
  for (const KeySide side : {KeySide::none, KeySide::both, KeySide::right, KeySide::left}) {
    if (const auto entry = keys.find(quantity, side); entry && *entry != nullptr) return *entry;
  }
  return nullptr;
}

}  // namespace

Result<std::optional<KeyedPose>> pose_of(const Keys& keys, const CameraParts& left, const CameraParts& right) {
  auto pose = pose_of_matrices(keys, left, right);
  if (pose && !*pose) pose = pose_of_transforms(keys);
  return pose;
}

Result<std::optional<double>> baseline_of(const Keys& keys, double fx_px) {
  if (const KeyEntry* named = first_of(keys, Quantity::baseline_in_unit)) {
    return std::optional<double>{std::abs(named->numbers.front())};
  }
  const auto baseline = number_of(keys, Quantity::baseline, KeySide::none);
  if (!baseline) return baseline.error();
  if (*baseline) return std::optional<double>{std::abs(**baseline)};
  const auto bf = number_of(keys, Quantity::bf, KeySide::none);
  if (!bf) return bf.error();
  if (!*bf || !(fx_px > 0.0)) return std::optional<double>{};
  return std::optional<double>{std::abs(**bf) / fx_px};
}

bool names_unit(const Keys& keys) {
  for (const Quantity q : {Quantity::translation, Quantity::pose, Quantity::translation_outwards}) {
    const KeyEntry* entry = first_of(keys, q);
    if (entry != nullptr && entry->meaning.unit_m > 0.0) return true;
  }
  return keys.has(Quantity::baseline_in_unit);
}

double length_unit_of(const Keys& keys, double length, std::vector<std::string>& notes) {
  for (const Quantity q : {Quantity::translation, Quantity::pose}) {
    const KeyEntry* entry = first_of(keys, q);
    if (entry != nullptr && entry->meaning.unit_m > 0.0) return entry->meaning.unit_m;
  }
  const KeyEntry* baseline = first_of(keys, Quantity::baseline_in_unit);
  if (baseline == nullptr || !(length > 0.0)) return 1.0;
  const double given = std::abs(baseline->numbers.front()) / length;
  constexpr double kRounded = 0.05;
  for (const double unit_m : {0.001, 0.01, 0.0254}) {
    if (std::abs(given / unit_m - 1.0) > kRounded) continue;
    notes.push_back(fmt::format("lengths are taken in units of {:g} m, since {} is {:.4g} m", unit_m,
                                printable(baseline->key.substr(0, 64)), std::abs(baseline->numbers.front())));
    return unit_m;
  }
  return 1.0;
}

}  // namespace cliquevo::drivers
