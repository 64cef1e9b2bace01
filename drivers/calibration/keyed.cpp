// SPDX-License-Identifier: BSD-3-Clause
// Files that name their matrices and numbers, each in its own way: OpenCV's FileStorage in YAML, XML and JSON,
// ORB-SLAM2 and 3, stella_vslam, and whatever else key_names.h understands.
#include <cmath>

#include <fmt/format.h>

#include "drivers/calibration/camera_parts.h"
#include "drivers/calibration/formats.h"
#include "drivers/calibration/keys.h"

namespace cliquevo::drivers {

namespace {

// What a reader looks for: the camera's own, else the one for both.
Result<const KeyEntry*> own_or_common(const Keys& keys, Quantity quantity, KeySide side, int index = 0) {
  auto own = keys.find(quantity, side, index);
  if (!own || *own != nullptr || side == KeySide::none) return own;
  return keys.find(quantity, KeySide::none, index);
}

Result<std::optional<double>> number(const Keys& keys, Quantity quantity, KeySide side, int index = 0) {
  const auto entry = own_or_common(keys, quantity, side, index);
  if (!entry) return entry.error();
  if (*entry == nullptr || (*entry)->numbers.size() != 1) return std::optional<double>{};
  return std::optional<double>{(*entry)->numbers.front()};
}

// fx, fy, cx, cy as numbers of their own; false: there are none.
Result<bool> read_focal_lengths(const Keys& keys, KeySide side, CameraCalibration& camera) {
  const auto f = number(keys, Quantity::focal, side);
  if (!f) return f.error();
  double values[4] = {f->value_or(0.0), f->value_or(0.0), 0.0, 0.0};
  int i = 0;
  int found = *f ? 2 : 0;
  for (const Quantity q : {Quantity::fx, Quantity::fy, Quantity::cx, Quantity::cy}) {
    const auto value = number(keys, q, side);
    if (!value) return value.error();
    if (*value) {
      found += i >= 2 || !*f ? 1 : 0;
      values[i] = **value;
    }
    ++i;
  }
  if (found < 4) return false;
  if (auto ok = set_camera_matrix({values[0], 0, values[2], 0, values[1], values[3], 0, 0, 1}, "fx", camera); !ok) {
    return ok.error();
  }
  return true;
}

Result<void> read_matrix(const KeyEntry& K, CameraParts& parts) {
  if (K.numbers.size() == 4) {  // fx fy cx cy
    const std::vector<double>& v = K.numbers;
    return put_camera_matrix({v[0], 0, v[2], 0, v[1], v[3], 0, 0, 1}, K.where, parts);
  }
  if (K.numbers.size() != 9) {
    return Error{fmt::format("{} has {} numbers instead of 9", printable(K.key), K.numbers.size()), K.where,
                 "copy the calibration again: it is torn"};
  }
  return put_camera_matrix(K.numbers, K.where, parts);
}

bool is_fisheye_name(std::string name) {
  for (char& c : name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return name.find("fish") != std::string::npos || name.find("kannala") != std::string::npos ||
         name.find("equi") != std::string::npos || name.starts_with("kb");
}

// k1 k2 p1 p2 k3 ... as numbers of their own, in the model's order.
Result<void> read_terms(const Keys& keys, KeySide side, CameraParts& parts) {
  double k[7] = {};
  double p[3] = {};
  double s[5] = {};
  int most_k = 0;
  bool any_p = false;
  bool any_s = false;
  const auto take = [&](Quantity q, int index, double& into) -> Result<bool> {
    const auto value = number(keys, q, side, index);
    if (!value) return value.error();
    into = value->value_or(0.0);
    return value->has_value();
  };
  for (int i = 1; i <= 6; ++i) {
    const auto there = take(Quantity::k, i, k[i]);
    if (!there) return there.error();
    if (*there) most_k = i;
  }
  for (int i = 1; i <= 2; ++i) {
    const auto there = take(Quantity::p, i, p[i]);
    if (!there) return there.error();
    any_p = any_p || *there;
  }
  for (int i = 1; i <= 4; ++i) {
    const auto there = take(Quantity::s, i, s[i]);
    if (!there) return there.error();
    any_s = any_s || (*there && s[i] != 0.0);
  }
  if (most_k == 0 && !any_p) return {};
  const bool fisheye = is_fisheye_name(parts.lens) || (parts.lens.empty() && most_k == 4 && !any_p);
  if (fisheye) {
    if (parts.lens.empty()) parts.lens = "equidistant";
    parts.D = {k[1], k[2], k[3], k[4]};
    return {};
  }
  parts.D = {k[1], k[2], p[1], p[2], k[3]};
  if (most_k > 3 || any_s) parts.D.insert(parts.D.end(), {k[4], k[5], k[6]});
  if (any_s) parts.D.insert(parts.D.end(), {s[1], s[2], s[3], s[4]});
  if (parts.lens.empty()) parts.lens = "pinhole";  // the terms have their names
  return {};
}

// The model's name. Words that name no lens ("type: stereo") count only where the key names distortion, and a rectified
// camera's "perspective" not beside the raw ones' lens.
Result<std::string> lens_name(const Keys& keys, KeySide side) {
  std::string lens;
  for (const KeyEntry* entry : keys.lenses(side)) {
    CameraCalibration unused;
    const std::string& word = entry->word;
    const bool plain = word == "pinhole" || word == "PinHole" || word == "Pinhole" || word == "perspective";
    const bool known =
        set_distortion(word, {0, 0, 0, 0}, "", unused).ok() || set_distortion(word, {0, 0}, "", unused).ok();
    if (plain || (!known && entry->key.find("istort") == std::string::npos)) continue;
    if (!lens.empty() && lens != word) {
      return Error{"calibration names two lens models", entry->where,
                   "leave one of " + printable(lens) + " and " + printable(word.substr(0, 32))};
    }
    lens = word;
  }
  return lens;
}

Result<void> read_lens(const Keys& keys, KeySide side, CameraParts& parts) {
  const auto lens = lens_name(keys, side);
  if (!lens) return lens.error();
  parts.lens = *lens;
  const auto D = own_or_common(keys, Quantity::distortion, side);
  if (!D) return D.error();
  parts.D_where = parts.where;
  if (*D == nullptr) return read_terms(keys, side, parts);
  parts.D = (*D)->numbers;
  parts.D_where = (*D)->where;
  return {};
}

Result<void> read_size(const Keys& keys, KeySide side, CameraParts& parts) {
  for (const Quantity q : {Quantity::size, Quantity::shape}) {
    const auto list = own_or_common(keys, q, side);
    if (!list) return list.error();
    if (*list == nullptr) continue;
    const std::vector<double>& v = (*list)->numbers;
    const auto size =
        q == Quantity::size ? size_from(v[0], v[1], (*list)->where) : size_from(v[1], v[0], (*list)->where);
    if (!size) return size.error();
    parts.camera.width = size->first;
    parts.camera.height = size->second;
    return {};
  }
  const auto width = number(keys, Quantity::width, side);
  if (!width) return width.error();
  const auto height = number(keys, Quantity::height, side);
  if (!height) return height.error();
  if (!*width || !*height) return {};
  const auto size = size_from(**width, **height, parts.where);
  if (!size) return size.error();
  parts.camera.width = size->first;
  parts.camera.height = size->second;
  return {};
}

Result<CameraParts> read_parts(const Keys& keys, KeySide side, const std::string& path) {
  CameraParts parts;
  parts.where = path;
  const auto K = own_or_common(keys, Quantity::camera_matrix, side);
  if (!K) return K.error();
  if (*K != nullptr) {
    if (auto ok = read_matrix(**K, parts); !ok) return ok.error();
  } else {
    const auto there = read_focal_lengths(keys, side, parts.camera);
    if (!there) return Error{there.error().what, path + " (" + there.error().where + ")", there.error().remedy};
    if (!*there && side == KeySide::right) {  // one camera's numbers for both
      if (const auto left = read_focal_lengths(keys, KeySide::left, parts.camera); !left) return left.error();
    }
  }
  if (auto ok = read_size(keys, side, parts); !ok) return ok.error();
  if (auto ok = read_lens(keys, side, parts); !ok) return ok.error();
  const auto P = keys.find(Quantity::projection, side);
  if (!P) return P.error();
  if (*P != nullptr) parts.P = (*P)->numbers;
  for (const Quantity q : {Quantity::rectification, Quantity::rotation}) {
    const auto R = keys.find(q, side);
    if (!R) return R.error();
    if (*R == nullptr || (*R)->numbers.size() != 9 || parts.R) continue;
    if (auto ok = put_rectification((*R)->numbers, (*R)->where, parts); !ok) return ok.error();
  }
  return parts;
}

Result<Eigen::Matrix3d> rotation_of(const KeyEntry& R) {
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

using Pose = std::optional<RigidTransform>;

Result<Pose> pose_of_matrices(const Keys& keys) {
  for (const KeySide side : {KeySide::none, KeySide::both, KeySide::right}) {
    const auto T = keys.find(Quantity::translation, side);
    if (!T) return T.error();
    if (*T == nullptr) continue;
    const auto R = keys.find(Quantity::rotation, side);
    if (!R) return R.error();
    if (*R == nullptr) return Error{"calibration lacks R, the rotation between the cameras", (*T)->where, "name it R"};
    const auto rotation = rotation_of(**R);
    if (!rotation) return rotation.error();
    RigidTransform pose{*rotation, {(*T)->numbers[0], (*T)->numbers[1], (*T)->numbers[2]}};
    if (side == KeySide::both) return Pose{right_from_left(pose)};
    if (side == KeySide::right && keys.has(Quantity::translation, KeySide::left)) {
      // Each camera's own pose: from a common frame to the camera.
      const auto T_left = keys.find(Quantity::translation, KeySide::left);
      const auto R_left = keys.find(Quantity::rotation, KeySide::left);
      if (!T_left) return T_left.error();
      if (!R_left) return R_left.error();
      if (*R_left == nullptr) return Error{"calibration lacks the left camera's rotation", (*T_left)->where, "add it"};
      const auto left = rotation_of(**R_left);
      if (!left) return left.error();
      const std::vector<double>& t = (*T_left)->numbers;
      pose = pose * RigidTransform{*left, {t[0], t[1], t[2]}}.inverse();
    }
    return Pose{pose};
  }
  return Pose{};
}

Result<Pose> pose_of_transforms(const Keys& keys) {
  for (const KeySide side : {KeySide::both, KeySide::none, KeySide::right}) {
    const auto entry = keys.find(Quantity::pose, side);
    if (!entry) return entry.error();
    if (*entry == nullptr || (side == KeySide::none && (*entry)->meaning.against_body)) continue;
    const auto T = transform_from((*entry)->numbers, (*entry)->where);
    if (!T) return T.error();
    if (side != KeySide::right) return Pose{right_from_left(*T)};
    const auto other = keys.find(Quantity::pose, KeySide::left);
    if (!other) return other.error();
    if (*other == nullptr) {
      if ((*entry)->meaning.against_body) continue;
      return Pose{right_from_left(*T)};
    }
    const auto T_left = transform_from((*other)->numbers, (*other)->where);
    if (!T_left) return T_left.error();
    // Unnamed frames: of the two readings the one with the right camera on the right.
    const RigidTransform to_body = T->inverse() * *T_left;
    const RigidTransform from_body = *T * T_left->inverse();
    if ((*entry)->meaning.against_body) return Pose{(*entry)->meaning.body_first ? to_body : from_body};
    return Pose{from_body.t.x() < 0.0 ? from_body : to_body};
  }
  return Pose{};
}

// baseline, or bf (of the rectified camera's fx); nothing = neither.
Result<std::optional<double>> baseline_of(const Keys& keys, double fx_px) {
  const auto baseline = number(keys, Quantity::baseline, KeySide::none);
  if (!baseline) return baseline.error();
  if (*baseline) return std::optional<double>{std::abs(**baseline)};
  const auto bf = number(keys, Quantity::bf, KeySide::none);
  if (!bf) return bf.error();
  if (!*bf || !(fx_px > 0.0)) return std::optional<double>{};
  return std::optional<double>{std::abs(**bf) / fx_px};
}

// ORB-SLAM2's and stella_vslam's rectified camera beside the raw ones: Camera.fx and so on, with Camera.bf.
Result<void> add_projections(const Keys& keys, CameraParts& left, CameraParts& right) {
  if (!left.P.empty() || !right.P.empty() || !left.R || !right.R) return {};
  CameraCalibration rectified;
  const auto there = read_focal_lengths(keys, KeySide::none, rectified);
  if (!there) return there.error();
  if (!*there) return {};
  const auto baseline = baseline_of(keys, rectified.fx_px);
  if (!baseline) return baseline.error();
  if (!*baseline) return {};
  left.P = {rectified.fx_px, 0, rectified.cx_px, 0, 0, rectified.fy_px, rectified.cy_px, 0, 0, 0, 1, 0};
  right.P = left.P;
  right.P[3] = -rectified.fx_px * **baseline;
  return {};
}

Result<StereoCalibration> rig_of(const Keys& keys, const std::string& path, const CalibrationRequest& request) {
  Result<CameraParts> left = read_parts(keys, KeySide::left, path);
  if (!left) return left.error();
  Result<CameraParts> right = read_parts(keys, KeySide::right, path);
  if (!right) return right.error();
  if (auto ok = add_projections(keys, *left, *right); !ok) return ok.error();
  Result<Pose> pose = pose_of_matrices(keys);
  if (pose && !*pose) pose = pose_of_transforms(keys);
  if (!pose) return pose.error();
  const bool projections = left->P.size() == 12 && right->P.size() == 12;
  if (!*pose && projections) {
    if (!left->R && left->D.empty()) left->R = Eigen::Matrix3d::Identity();
    if (!right->R && right->D.empty()) right->R = Eigen::Matrix3d::Identity();
    return rig_of_projections(*left, *right, std::nullopt, request);
  }
  if (left->camera.fx_px <= 0.0 || right->camera.fx_px <= 0.0) {
    return calibration_error("calibration lacks the left or the right camera's matrix", path);
  }
  if (!*pose) {  // parallel cameras
    const auto baseline = baseline_of(keys, left->camera.fx_px);
    if (!baseline) return baseline.error();
    if (!*baseline) {
      return Error{"calibration lacks the pose of the right camera", path,
                   "it needs R and T, a 4x4 transform, projections P1 and P2, a baseline, or Camera.bf"};
    }
    *pose = RigidTransform{Eigen::Matrix3d::Identity(), {-**baseline, 0.0, 0.0}};
  }
  // Rotations of cameras with a translation each are poses, no rectification.
  if (keys.has(Quantity::translation, KeySide::right)) left->R = right->R = std::nullopt;
  return rig_of_pose(*left, *right, **pose, request);
}

bool has_cameras(const Keys& keys) {
  for (const Quantity q : {Quantity::camera_matrix, Quantity::fx, Quantity::focal, Quantity::projection}) {
    if (keys.has(q, KeySide::right)) return true;
  }
  return false;
}

// The cameras' own files beside one that holds their pose alone.
bool add_cameras_beside(const std::string& path, const OtherFile& other, Keys& keys) {
  for (const char* side : {"left", "right"}) {
    std::vector<std::string> paths;
    for (const std::string extension : {".yml", ".yaml", ".xml", ".json"}) {
      for (const char* pattern : {"{}", "camera_{}", "{}_camera", "cam_{}", "{}_cam", "intrinsics_{}", "{}_intrinsics",
                                  "calib_{}", "{}_calib", "calibration_{}", "{}_calibration"}) {
        paths.push_back(beside(path, fmt::format(fmt::runtime(pattern), side) + extension));
      }
      paths.push_back(beside(path, (side[0] == 'l' ? "cam0" : "cam1") + extension));
    }
    const auto camera = read_other(other, paths);
    if (!camera) return false;
    DocumentNode root;
    root.kind = DocumentNode::Kind::map;
    root.entries.push_back({side, camera->root()});
    keys.add(Document::of(std::move(root), camera->path()));
  }
  return true;
}

bool has_pose(const Keys& keys) {
  const bool matrices = keys.has(Quantity::translation) && keys.has(Quantity::rotation);
  return matrices || keys.has(Quantity::pose) || keys.has(Quantity::projection, KeySide::right) ||
         keys.has(Quantity::baseline) || keys.has(Quantity::bf);
}

}  // namespace

bool is_keyed(const CalibrationText& file) {
  if (!file.document) return false;
  const Keys keys(*file.document);
  const bool one_for_both = keys.has(Quantity::fx) && (keys.has(Quantity::bf) || keys.has(Quantity::baseline));
  const bool matrix_for_both =
      keys.has(Quantity::camera_matrix) && (keys.has(Quantity::baseline) || keys.has(Quantity::bf));
  const bool extrinsics = keys.has(Quantity::translation) && keys.has(Quantity::rotation);
  return has_cameras(keys) || one_for_both || matrix_for_both || extrinsics;
}

Result<StereoCalibration> read_keyed(const CalibrationText& file, const CalibrationRequest& request,
                                     const OtherFile& other) {
  Keys keys(*file.document);
  const bool projections = keys.has(Quantity::projection, KeySide::right);
  const bool cameras = keys.has(Quantity::camera_matrix) || keys.has(Quantity::fx) || keys.has(Quantity::focal);
  if (cameras && has_pose(keys)) return rig_of(keys, file.path, request);
  // Cameras in one file, their pose in another.
  std::vector<std::string> paths;
  for (const auto& [from, to] :
       {std::pair{"intrinsic", "extrinsic"}, {"Intrinsic", "Extrinsic"}, {"intrin", "extrin"}}) {
    paths.push_back(replaced(file.path, from, to, 1));
    paths.push_back(replaced(file.path, to, from, 1));
  }
  const auto second = read_other(other, paths);
  if (!second && projections && !keys.has(Quantity::translation)) return rig_of(keys, file.path, request);
  if (!second && !cameras && add_cameras_beside(file.path, other, keys)) return rig_of(keys, file.path, request);
  if (!second) {
    return cameras ? Error{"calibration lacks R and T between the cameras", file.path, "name the stereo file"}
                   : Error{"calibration lacks the camera matrices", file.path,
                           "name the file that holds them too, or put them beside it as left.yml and right.yml"};
  }
  keys.add(*second);
  return rig_of(keys, file.path, request);
}

}  // namespace cliquevo::drivers
