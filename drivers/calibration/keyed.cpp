// SPDX-License-Identifier: BSD-3-Clause
// Files that name their matrices and numbers, each in its own way: OpenCV's FileStorage in YAML, XML and JSON,
// ORB-SLAM2 and 3, stella_vslam, and whatever else key_names.h understands.
#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "drivers/calibration/baseline.h"
#include "drivers/calibration/format.h"
#include "drivers/calibration/keyed_parts.h"
#include "drivers/calibration/keyed_pose.h"

namespace cliquevo::drivers {

namespace {

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

// The rectified camera of ORB-SLAM's settings, where LEFT and RIGHT are another rig's that were left in the file.
Result<std::optional<StereoCalibration>> rig_beside_leftovers(const Keys& keys, const CameraParts& left,
                                                              const std::string& path,
                                                              const CalibrationRequest& request) {
  using Rig = std::optional<StereoCalibration>;
  CameraParts camera;
  camera.where = path;
  const auto there = read_focal_lengths(keys, KeySide::none, camera.camera);
  if (!there || !*there || left.P.size() != 12) return Rig{};
  const auto baseline = baseline_of(keys, camera.camera.fx_px);
  if (!baseline || !*baseline) return Rig{};
  const double fx_px = camera.camera.fx_px;
  const auto agrees = [fx_px](double other_px) { return std::abs(fx_px - other_px) < 1e-3 * other_px; };
  if (agrees(left.P[0]) || agrees(left.camera.fx_px)) return Rig{};
  const auto width = number_of(keys, Quantity::width, KeySide::none);
  const auto height = number_of(keys, Quantity::height, KeySide::none);
  const bool of_the_images =
      width && height && *width && *height && **width == request.width && **height == request.height;
  const bool left_is = left.camera.width == request.width && left.camera.height == request.height;
  if (left_is && !of_the_images) return Rig{};
  if (!of_the_images || left_is) {
    return Error{fmt::format("calibration has two rectified cameras: fx of {:.2f} px, and of {:.2f} px by LEFT.P",
                             fx_px, left.P[0]),
                 path, "leave LEFT and RIGHT out if the images are rectified; else put LEFT.P's numbers to Camera"};
  }
  camera.camera.width = request.width;
  camera.camera.height = request.height;
  auto rig = rig_of_pose(camera, camera, {Eigen::Matrix3d::Identity(), {-**baseline, 0.0, 0.0}}, request);
  if (!rig) return rig.error();
  rig->notes.push_back(
      fmt::format("Camera's fx of {:.2f} px taken for that of rectified images, as LEFT.P has another one", fx_px));
  return Rig{std::move(*rig)};
}

bool same_cameras(const CameraParts& a, const CameraParts& b) {
  return a.camera.fx_px == b.camera.fx_px && a.camera.fy_px == b.camera.fy_px && a.camera.cx_px == b.camera.cx_px &&
         a.camera.cy_px == b.camera.cy_px && a.D == b.D && !a.R && !b.R;
}

// A first camera that lies on the right, for certain, is the right one: by poses in a body, by projections that
// were computed from R and T, or where both cameras are one and the same. True: they were exchanged, and so are their
// images; cameras that are one and the same show only that T is meant the other way round.
bool order_cameras(CameraParts& left, CameraParts& right, KeyedPose& pose, std::vector<std::string>& notes) {
  if (pose.T_right_left.t.x() <= 0.0) return false;
  const bool computed = left.P.size() == 12 && right.P.size() == 12 && left.R && right.R && right.P[3] > left.P[3];
  const bool ideal = same_cameras(left, right) && pose.T_right_left.R.isIdentity(1e-9);
  if (!pose.directed && !computed && !ideal) return false;
  std::swap(left, right);
  pose.T_right_left = pose.T_right_left.inverse();
  notes.push_back(kExchangedNote);
  return pose.directed || computed;
}

// Cameras with their rectified ones and no pose besides.
Result<StereoCalibration> rig_by_projections(const Keys& keys, CameraParts left, CameraParts right,
                                             const CalibrationRequest& request) {
  for (CameraParts* parts : {&left, &right}) {
    if (!parts->R && parts->D.empty()) parts->R = Eigen::Matrix3d::Identity();
  }
  std::optional<Eigen::Vector3d> T;
  if (left.P[3] == 0.0 && right.P[3] == 0.0) {
    const auto baseline = baseline_of(keys, right.P[0]);
    if (!baseline) return baseline.error();
    if (*baseline) T = Eigen::Vector3d(-**baseline, 0.0, 0.0);
  }
  std::vector<std::string> notes;
  const double unit_m = length_unit_of(keys, std::abs(right.P[3] - left.P[3]) / std::abs(right.P[0]), notes);
  auto rig = rig_of_projections(std::move(left), std::move(right), T, request, unit_m);
  if (rig) rig->notes.insert(rig->notes.begin(), notes.begin(), notes.end());
  return rig;
}

// Cameras whose pose is given by their distance alone.
Result<KeyedPose> parallel_pose(const Keys& keys, const CameraParts& left, const std::string& path,
                                std::vector<std::string>& notes) {
  const auto baseline = baseline_of(keys, left.camera.fx_px);
  if (!baseline) return baseline.error();
  if (!*baseline) {
    return Error{"calibration lacks the pose of the right camera", path,
                 "it needs R and T, a 4x4 transform, projections P1 and P2, a baseline, or Camera.bf"};
  }
  if (std::any_of(left.D.begin(), left.D.end(), [](double k) { return k != 0.0; })) {
    notes.push_back("no rotation between the cameras is given: they are taken for parallel");
  }
  return KeyedPose{{Eigen::Matrix3d::Identity(), {-**baseline, 0.0, 0.0}}, true, {}};
}

// What the file has besides two cameras and their pose: noted, or refused where it would be ignored.
Result<void> look_around(const Keys& keys, const std::string& path, std::vector<std::string>& notes) {
  if (keys.poses_are_of_others()) {
    return Error{fmt::format("calibration is of {} cameras, and its poses are of pairs", keys.cameras()), path,
                 "name a file with the two cameras of the images and their R and T alone"};
  }
  if (keys.cameras() > 2) {
    notes.push_back(fmt::format("calibration is of {} cameras: the first two are taken", keys.cameras()));
  }
  for (const int which : {0, 1}) {
    const auto offset = keys.find(Quantity::row_offset, KeySide::none, which);
    if (!offset) return offset.error();
    if (*offset == nullptr || (*offset)->numbers.front() == 0.0) continue;
    return Error{fmt::format("calibration shifts the images against each other by {:g} px, which is not undone",
                             (*offset)->numbers.front()),
                 (*offset)->where,
                 "give each camera its own principal point in its place, or 0 if the images are shifted already"};
  }
  return {};
}

// How camera matrices had to be read.
void note_matrices(const CameraParts& left, const CameraParts& right, std::vector<std::string>& notes) {
  if (left.transposed && right.transposed) {
    notes.push_back("camera matrices stand as their transposes, as MATLAB's: R is read likewise");
  }
  if (left.open || right.open) notes.push_back("camera matrices end in 0 0 0: taken for 0 0 1");
}

// Cameras with a pose, or with their distance alone.
Result<StereoCalibration> rig_by_pose(const Keys& keys, CameraParts left, CameraParts right,
                                      std::optional<KeyedPose> pose, const std::string& path,
                                      const CalibrationRequest& request) {
  if (left.camera.fx_px <= 0.0 || right.camera.fx_px <= 0.0) {
    return calibration_error("calibration lacks the left or the right camera's matrix", path);
  }
  std::vector<std::string> notes;
  double unit_m = 1.0;
  const bool distance_alone = !pose;
  if (pose) {
    unit_m = length_unit_of(keys, pose->T_right_left.t.norm(), notes);
  } else {
    auto parallel = parallel_pose(keys, left, path, notes);
    if (!parallel) return parallel.error();
    pose = *parallel;
  }
  note_matrices(left, right, notes);
  if (!pose->note.empty()) notes.push_back(pose->note);
  // Rotations of cameras with a translation each are poses, no rectification.
  if (keys.has(Quantity::translation, KeySide::right)) left.R = right.R = std::nullopt;
  const bool exchanged = order_cameras(left, right, *pose, notes);
  auto rig = rig_of_pose(left, right, pose->T_right_left, request, unit_m);
  if (!rig) return rig;
  const bool unit_known = distance_alone || names_unit(keys) || request.options.baseline_unit_m > 0.0;
  if (!unit_known) {
    if (auto wide = note_wide_baseline(rig->T_right_left.t.norm())) notes.push_back(std::move(*wide));
  }
  rig->exchanged = exchanged;
  rig->notes.insert(rig->notes.begin(), notes.begin(), notes.end());
  return rig;
}

Result<StereoCalibration> rig_of(const Keys& keys, const std::string& path, const CalibrationRequest& request) {
  std::vector<std::string> notes;
  if (auto ok = look_around(keys, path, notes); !ok) return ok.error();
  Result<CameraParts> left = read_parts(keys, KeySide::left, path);
  if (!left) return left.error();
  Result<CameraParts> right = read_parts(keys, KeySide::right, path);
  if (!right) return right.error();
  auto plain = rig_beside_leftovers(keys, *left, path, request);
  if (!plain) return plain.error();
  if (*plain) return std::move(**plain);
  if (auto ok = add_projections(keys, *left, *right); !ok) return ok.error();
  const auto pose = pose_of(keys, *left, *right);
  if (!pose) return pose.error();
  const bool by_projections = !*pose && left->P.size() == 12 && right->P.size() == 12;
  auto rig = by_projections ? rig_by_projections(keys, *left, *right, request)
                            : rig_by_pose(keys, *left, *right, *pose, path, request);
  if (rig) rig->notes.insert(rig->notes.begin(), notes.begin(), notes.end());
  return rig;
}

bool has_cameras(const Keys& keys) {
  for (const Quantity q :
       {Quantity::camera_matrix, Quantity::fx, Quantity::focal, Quantity::focals, Quantity::projection}) {
    if (keys.has(q, KeySide::right)) return true;
  }
  return false;
}

void add_under(const char* side, const Document& camera, Keys& keys) {
  DocumentNode root;
  root.kind = DocumentNode::Kind::map;
  root.entries.push_back({side, camera.root()});
  keys.add(Document::of(std::move(root), camera.path()));
}

// The cameras' own files beside one that holds their pose alone.
bool add_cameras_beside(const std::string& path, const OtherFile& other, Keys& keys) {
  for (const char* side : {"left", "right"}) {
    std::vector<std::string> paths;
    for (const std::string extension : {".yml", ".yaml", ".xml", ".json", ".npz"}) {
      for (const char* pattern : {"{}", "camera_{}", "{}_camera", "cam_{}", "{}_cam", "intrinsics_{}", "{}_intrinsics",
                                  "calib_{}", "{}_calib", "calibration_{}", "{}_calibration"}) {
        paths.push_back(beside(path, fmt::format(fmt::runtime(pattern), side) + extension));
      }
      paths.push_back(beside(path, (side[0] == 'l' ? "cam0" : "cam1") + extension));
    }
    const auto camera = read_other(other, paths);
    if (!camera) return false;
    add_under(side, *camera, keys);
  }
  return true;
}

bool has_distance(const Keys& keys) {
  return keys.has(Quantity::baseline) || keys.has(Quantity::baseline_in_unit) || keys.has(Quantity::bf);
}

bool has_pose(const Keys& keys) {
  const bool matrices = keys.has(Quantity::translation) && keys.has(Quantity::rotation);
  return matrices || keys.has(Quantity::pose) || keys.has(Quantity::projection, KeySide::right) ||
         keys.has(Quantity::translation_outwards) || has_distance(keys);
}

bool has_camera(const Keys& keys, KeySide side) {
  for (const Quantity q : {Quantity::camera_matrix, Quantity::fx, Quantity::focal, Quantity::focals}) {
    if (keys.has(q, side)) return true;
  }
  return false;
}

// Two files of one camera each, with their poses in them or in a third one; nothing = the other is not there.
std::optional<Keys> pair_of_files(const CalibrationText& file, const OtherFile& other) {
  const auto second = read_other(other, other_camera_paths(file.path));
  if (!second || second->path() == file.path) return std::nullopt;
  const Keys theirs(*second);
  if (!has_camera(theirs, KeySide::none) || has_cameras(theirs)) return std::nullopt;
  const bool swapped = is_right_of(file.path, second->path());
  Keys keys;
  add_under("left", swapped ? *second : *file.document, keys);
  add_under("right", swapped ? *file.document : *second, keys);
  if (has_pose(keys)) return keys;
  std::vector<std::string> paths;
  for (const std::string extension : {".yml", ".yaml", ".xml", ".json", ".npz"}) {
    for (const char* name :
         {"stereo", "extrinsics", "extrinsic", "stereo_extrinsics", "stereo_calib", "stereo_params",
          "stereo_calibration", "calib_stereo", "cam_stereo", "R_T", "calib_chain", "camchain", "chain"}) {
      paths.push_back(beside(file.path, name + extension));
    }
  }
  if (const auto pose = read_other(other, paths)) keys.add(*pose);
  return keys;
}

}  // namespace

bool is_keyed(const CalibrationText& file) {
  if (!file.document) return false;
  const Keys keys(*file.document);
  const bool one_for_both = (keys.has(Quantity::fx) || keys.has(Quantity::focal) || keys.has(Quantity::focals) ||
                             keys.has(Quantity::camera_matrix)) &&
                            has_distance(keys);
  const bool extrinsics = keys.has(Quantity::translation) && keys.has(Quantity::rotation);
  return has_cameras(keys) || one_for_both || extrinsics;
}

Result<StereoCalibration> read_keyed(const CalibrationText& file, const CalibrationRequest& request,
                                     const OtherFile& other) {
  Keys keys(*file.document);
  if (has_camera(keys, KeySide::none) && !has_cameras(keys)) {
    if (const auto both = pair_of_files(file, other)) return rig_of(*both, file.path, request);
  }
  const bool projections = keys.has(Quantity::projection, KeySide::right);
  const bool cameras = keys.has(Quantity::camera_matrix) || keys.has(Quantity::fx) || keys.has(Quantity::focal) ||
                       keys.has(Quantity::focals);
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

bool is_one_camera(const CalibrationText& file) { return has_camera(Keys(*file.document), KeySide::none); }

Result<StereoCalibration> read_one_camera(const CalibrationText& file, const CalibrationRequest& request,
                                          const OtherFile& other) {
  const auto both = pair_of_files(file, other);
  if (both && has_pose(*both)) return rig_of(*both, file.path, request);
  if (both) {
    return Error{"calibration lacks R and T between the cameras", file.path,
                 "put them beside it in stereo.yml, or name a file with both cameras and their pose"};
  }
  return Error{"calibration is of a single camera", file.path,
               "name a file with both cameras and their pose, or put the other camera's beside it, named left and "
               "right or cam0 and cam1"};
}

}  // namespace cliquevo::drivers
