// SPDX-License-Identifier: BSD-3-Clause
#include "tools/reference.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <fmt/format.h>

#include "drivers/calibration/calibration.h"
#include "drivers/calibration_file.h"
#include "stereo/rectification.h"

namespace cliquevo::tools {

namespace fs = std::filesystem;

namespace {

bool is_rotation(const Eigen::Matrix3d& R) {
  return (R * R.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-3 && R.determinant() > 0.0;
}

// T_BS of a sensor.yaml: from the sensor to the body.
Result<RigidTransform> read_mounting(const fs::path& file) {
  const auto bad = [&](const char* what) { return Error{what, file.string(), "copy the recording again"}; };
  std::error_code ec;
  if (!fs::is_regular_file(file, ec) || fs::file_size(file, ec) > (1U << 20U)) return bad("no sensor.yaml");
  std::ostringstream whole;
  whole << std::ifstream(file).rdbuf();
  const std::string text = whole.str();
  const std::size_t key = text.find("T_BS");
  const std::size_t open = key == std::string::npos ? key : text.find('[', key);
  const std::size_t close = open == std::string::npos ? open : text.find(']', open);
  if (close == std::string::npos) return bad("sensor.yaml has no T_BS");
  std::string list = text.substr(open + 1, close - open - 1);
  std::replace(list.begin(), list.end(), ',', ' ');
  std::istringstream in(list);
  Eigen::Matrix4d T;
  for (int i = 0; i < 16; ++i) {
    if (!(in >> T(i / 4, i % 4))) return bad("T_BS has fewer than 16 numbers");
  }
  const Eigen::Matrix3d R = T.topLeftCorner<3, 3>();
  const bool rotation = R.allFinite() && (R * R.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-3;
  if (!rotation || R.determinant() < 0.0 || !(T.topRightCorner<3, 1>().norm() < 1e4)) {
    return bad("T_BS is no rotation and translation");
  }
  return RigidTransform{R, T.topRightCorner<3, 1>()};
}

// T_cam_imu of the first camera in a Kalibr file, turned round: from the camera to the body.
std::optional<RigidTransform> mounting_in_kalibr(const std::string& file) {
  std::error_code ec;
  if (file.empty() || !fs::is_regular_file(file, ec) || fs::file_size(file, ec) > (1U << 20U)) return std::nullopt;
  std::ostringstream whole;
  whole << std::ifstream(file).rdbuf();
  const std::string text = whole.str();
  const std::size_t camera = text.find("cam0:");
  const std::string_view key = "T_cam_imu:";
  const std::size_t at = camera == std::string::npos ? camera : text.find(key, camera);
  if (at == std::string::npos || text.find("cam1:", camera) < at) return std::nullopt;
  std::string list = text.substr(at + key.size(), 2000);
  for (std::size_t i = 0; i < list.size(); ++i) {
    const bool dash = list[i] == '-' && i + 1 < list.size() && list[i + 1] == ' ';  // of YAML's lists
    if (dash || list[i] == '[' || list[i] == ']' || list[i] == ',') list[i] = ' ';
  }
  std::istringstream in(list);
  Eigen::Matrix4d T;
  for (int i = 0; i < 16; ++i) {
    if (!(in >> T(i / 4, i % 4))) return std::nullopt;
  }
  const RigidTransform T_camera_body{T.topLeftCorner<3, 3>(), T.topRightCorner<3, 1>()};
  if (!is_rotation(T_camera_body.R) || !(T_camera_body.t.norm() < 1e4)) return std::nullopt;
  return T_camera_body.inverse();
}

Error unknown_mounting(const std::string& path, const daemon::Trajectory& trajectory, const std::string& remedy) {
  return {fmt::format("the reference is of {}, and where the camera sits is not known", trajectory.body), path, remedy};
}

struct MountedCamera {
  RigidTransform T_body_camera;
  std::string calibration;
};

// From cam0/sensor.yaml of the recording, else from its Kalibr file.
std::optional<MountedCamera> camera_in(const fs::path& recording) {
  const fs::path sensor = recording / "cam0" / "sensor.yaml";
  if (const auto mounting = read_mounting(sensor)) return MountedCamera{*mounting, sensor.string()};
  for (const fs::path& folder : {recording, recording.parent_path(), recording.parent_path() / "dso"}) {
    const std::string file = drivers::find_calibration(folder.string());
    if (const auto mounting = mounting_in_kalibr(file)) return MountedCamera{*mounting, file};
  }
  return std::nullopt;
}

// From the rectified left camera to the frame whose poses a EuRoC ground truth holds.
Result<RigidTransform> rectified_camera_on_body(const std::string& path, const daemon::Trajectory& trajectory,
                                                const StereoCalibration* calibration) {
  std::error_code ec;
  const fs::path folder = fs::weakly_canonical(path, ec).parent_path();
  const fs::path recording = folder.parent_path();
  const auto camera = camera_in(recording);
  if (!camera) {
    return unknown_mounting(
        path, trajectory,
        fmt::format("leave it in its recording: {} has it; or let cliquevo eval take it as it is, with "
                    "--reference-frame",
                    (recording / "cam0" / "sensor.yaml").string()));
  }
  // The ground truth's own sensor is the body, as a rule.
  RigidTransform T_body_sensor;
  if (const fs::path own = folder / "sensor.yaml"; fs::is_regular_file(own, ec)) {
    if (const auto read = read_mounting(own)) T_body_sensor = *read;
  }
  StereoCalibration read_here;
  if (calibration == nullptr) {
    auto read = drivers::read_calibration(camera->calibration, 0, 0);
    if (!read) return read.error();
    read_here = std::move(*read);
    calibration = &read_here;
  }
  const auto rectification = stereo::choose_rectification(*calibration);
  if (!rectification) return rectification.error();
  const RigidTransform T_camera_rectified{rectification->R_left.transpose(), Eigen::Vector3d::Zero()};
  return T_body_sensor.inverse() * camera->T_body_camera * T_camera_rectified;
}

// The numbers after `key` in one of KITTI-360's calibration files.
std::optional<std::vector<double>> numbers_after(const fs::path& file, const std::string& key, std::size_t count) {
  constexpr std::size_t kLongestLine = 4096;
  std::ifstream in(file);
  std::string line;
  while (std::getline(in, line) && line.size() < kLongestLine) {
    if (line.rfind(key, 0) != 0) continue;
    std::istringstream words(line.substr(key.size()));
    std::vector<double> out(count);
    for (double& value : out) {
      if (!(words >> value) || !(std::abs(value) < 1e4)) return std::nullopt;
    }
    return out;
  }
  return std::nullopt;
}

// KITTI-360: from the rectified left camera to the navigation unit, whose poses poses.txt holds. The data set's own
// chain: camera to unit (calib_cam_to_pose.txt) times the inverse of the rectifying rotation (perspective.txt).
Result<RigidTransform> rectified_camera_on_vehicle(const std::string& path) {
  std::error_code ec;
  const fs::path drive = fs::weakly_canonical(path, ec).parent_path();
  fs::path folder = drive;
  if (!fs::is_regular_file(folder / "calib_cam_to_pose.txt", ec)) {
    folder = drive.parent_path().parent_path() / "calibration";
  }
  if (!fs::is_regular_file(folder / "calib_cam_to_pose.txt", ec)) {
    return Error{"the reference is of the vehicle, and where its camera is mounted is not known", path,
                 "put KITTI-360's calib_cam_to_pose.txt and perspective.txt beside it, or give cam0_to_world.txt"};
  }
  const auto mounting = numbers_after(folder / "calib_cam_to_pose.txt", "image_00:", 12);
  const auto rectifying = numbers_after(folder / "perspective.txt", "R_rect_00:", 9);
  RigidTransform T_vehicle_camera;
  Eigen::Matrix3d R_rect = Eigen::Matrix3d::Zero();
  if (mounting && rectifying) {
    const Eigen::Matrix<double, 3, 4> T =
        Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(mounting->data());
    T_vehicle_camera = {T.leftCols<3>(), T.col(3)};
    R_rect = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(rectifying->data());
  }
  if (!is_rotation(T_vehicle_camera.R) || !is_rotation(R_rect)) {
    return Error{
        "cannot read where the camera is mounted", folder.string(),
        "image_00 in calib_cam_to_pose.txt is a rotation and translation, R_rect_00 in perspective.txt a rotation"};
  }
  return T_vehicle_camera * RigidTransform{R_rect.transpose(), Eigen::Vector3d::Zero()};
}

}  // namespace

namespace {

Result<RigidTransform> rectified_camera_on(const daemon::Trajectory& trajectory, const std::string& path,
                                           const StereoCalibration* calibration) {
  if (trajectory.mounting == daemon::BodyMounting::kitti360) return rectified_camera_on_vehicle(path);
  if (trajectory.mounting == daemon::BodyMounting::euroc)
    return rectified_camera_on_body(path, trajectory, calibration);
  return unknown_mounting(
      path, trajectory,
      "give poses of the left camera; cliquevo eval takes these as they are where --reference-frame "
      "says in which axes (body: X forward, Z up)");
}

// A remark that is no fault: what the reader concluded.
void add_note(const daemon::Trajectory& trajectory, const std::string& path, std::vector<Error>& out) {
  if (!trajectory.note.empty()) out.push_back({"not said in the file", path, trajectory.note});
}

}  // namespace

Result<daemon::Trajectory> read_reference(const std::string& path, const StereoCalibration* calibration) {
  auto trajectory = daemon::read_trajectory(path);
  if (!trajectory || !trajectory->of_body) return trajectory;
  const auto T_body_camera = rectified_camera_on(*trajectory, path, calibration);
  if (!T_body_camera) return T_body_camera.error();
  for (daemon::StampedPose& pose : trajectory->poses) pose.T_world_camera = pose.T_world_camera * *T_body_camera;
  return trajectory;
}

Result<ReferenceAndEstimate> read_compared(const std::string& reference, const std::string& estimate,
                                           bool frame_is_stated) {
  auto judged = daemon::read_trajectory(estimate);
  auto plain = daemon::read_trajectory(reference);
  if (!plain) return plain.error();
  if (!judged) return judged.error();
  ReferenceAndEstimate out;
  add_note(*plain, reference, out.warnings);
  add_note(*judged, estimate, out.warnings);
  if (judged->of_body && plain->of_body) {
    if (judged->body != plain->body) {
      out.warnings.push_back({fmt::format("the estimate is of {}, the reference of {}", judged->body, plain->body),
                              estimate, "both are compared as if of the same frame"});
    }
  } else if (judged->of_body) {
    out.warnings.push_back({fmt::format("the estimate is of {}, not of the camera", judged->body), estimate,
                            "only where the reference is of the same can more than the ATE be trusted"});
  } else if (plain->of_body) {
    auto of_camera = read_reference(reference);
    if (!of_camera && !frame_is_stated) return of_camera.error();
    if (of_camera) *plain = std::move(*of_camera);
  }
  out.reference = std::move(*plain);
  out.estimate = std::move(*judged);
  return out;
}

std::string reference_beside(const std::string& recording) {
  std::error_code ignored;
  for (const char* name : {"poses.txt", "groundtruth.tum", "state_groundtruth_estimate0/data.csv",
                           "mav0/state_groundtruth_estimate0/data.csv", "mocap0/data.csv", "mav0/mocap0/data.csv"}) {
    if (const fs::path file = fs::path(recording) / name; fs::is_regular_file(file, ignored)) return file.string();
  }
  // KITTI-360: data_2d_raw/DRIVE and data_poses/DRIVE.
  const fs::path drive = fs::weakly_canonical(recording, ignored);
  const fs::path poses = drive.parent_path().parent_path() / "data_poses" / drive.filename();
  for (const char* name : {"cam0_to_world.txt", "poses.txt"}) {
    if (fs::is_regular_file(poses / name, ignored)) return (poses / name).string();
  }
  return "";
}

namespace {

Result<RunReference> by_stamp(const daemon::Trajectory& trajectory, const std::string& path,
                              const std::vector<FrameRecord>& frames) {
  RunReference out;
  out.name = path;
  daemon::Trajectory estimate;
  estimate.format = daemon::TrajectoryFormat::tum;
  for (const FrameRecord& frame : frames) {
    daemon::StampedPose pose;
    pose.stamp_ns = frame.estimate.stamp_ns;
    pose.T_world_camera = frame.estimate.T_world_camera;
    estimate.poses.push_back(pose);
  }
  auto pairs = associate(trajectory, estimate, {});
  if (!pairs) return Error{pairs.error().what, path, pairs.error().remedy};
  out.pairs = std::move(*pairs);
  out.align = !trajectory.of_body;  // of unknown axes, but for those that were read with the camera's
  return out;
}

// Frames without a pose are left out.
Result<RunReference> by_number(const daemon::Trajectory& trajectory, const std::string& path,
                               const std::vector<FrameRecord>& frames, std::int64_t first_number) {
  RunReference out;
  out.name = path;
  std::size_t at = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const std::int64_t number = first_number + frames[i].index;
    while (at < trajectory.poses.size() && trajectory.poses[at].frame < number) ++at;
    if (at == trajectory.poses.size() || trajectory.poses[at].frame != number) continue;
    const vo::Estimate& estimate = frames[i].estimate;
    out.pairs.push_back({estimate.stamp_ns, i, trajectory.poses[at].T_world_camera, estimate.T_world_camera});
  }
  if (out.pairs.size() >= 2) return out;
  return Error{"reference has no pose for these frames", path,
               fmt::format("the run begins with frame {}: give the one of this recording", first_number)};
}

}  // namespace

Result<RunReference> reference_from_file(const std::string& path, const std::vector<FrameRecord>& frames,
                                         const drivers::SourceInfo& info) {
  const auto trajectory = read_reference(path, &info.calibration);
  if (!trajectory) return trajectory.error();
  if (trajectory->format == daemon::TrajectoryFormat::tum) return by_stamp(*trajectory, path, frames);
  if (trajectory->numbered) return by_number(*trajectory, path, frames, info.first_number);
  RunReference out;
  out.name = path;
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
