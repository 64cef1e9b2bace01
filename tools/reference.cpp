// SPDX-License-Identifier: BSD-3-Clause
#include "tools/reference.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <fmt/format.h>

#include "drivers/calibration_file.h"
#include "stereo/rectification.h"

namespace cliquevo::tools {

namespace fs = std::filesystem;

namespace {

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

// From the rectified left camera to the frame whose poses a EuRoC ground truth holds.
Result<RigidTransform> rectified_camera_on_body(const std::string& path, const StereoCalibration* calibration) {
  std::error_code ec;
  const fs::path folder = fs::weakly_canonical(path, ec).parent_path();
  const fs::path recording = folder.parent_path();
  const fs::path camera_file = recording / "cam0" / "sensor.yaml";
  const auto T_body_camera = read_mounting(camera_file);
  if (!T_body_camera) {
    return Error{"EuRoC ground truth is of the body, and where the camera sits is not known", path,
                 "leave it in its recording: " + camera_file.string() + " has it"};
  }
  // The ground truth's own sensor is the body, as a rule.
  RigidTransform T_body_sensor;
  if (const fs::path own = folder / "sensor.yaml"; fs::is_regular_file(own, ec)) {
    if (const auto read = read_mounting(own)) T_body_sensor = *read;
  }
  StereoCalibration read_here;
  if (calibration == nullptr) {
    auto read = drivers::read_calibration(camera_file.string(), 0, 0);
    if (!read) return read.error();
    read_here = std::move(*read);
    calibration = &read_here;
  }
  const auto rectification = stereo::choose_rectification(*calibration);
  if (!rectification) return rectification.error();
  const RigidTransform T_camera_rectified{rectification->R_left.transpose(), Eigen::Vector3d::Zero()};
  return T_body_sensor.inverse() * *T_body_camera * T_camera_rectified;
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

bool is_rotation(const Eigen::Matrix3d& R) {
  return (R * R.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-3 && R.determinant() > 0.0;
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

Result<daemon::Trajectory> read_reference(const std::string& path, const StereoCalibration* calibration) {
  auto trajectory = daemon::read_trajectory(path);
  if (!trajectory || !trajectory->of_body) return trajectory;
  const auto T_body_camera =
      trajectory->numbered ? rectified_camera_on_vehicle(path) : rectified_camera_on_body(path, calibration);
  if (!T_body_camera) return T_body_camera.error();
  for (daemon::StampedPose& pose : trajectory->poses) pose.T_world_camera = pose.T_world_camera * *T_body_camera;
  return trajectory;
}

std::string reference_beside(const std::string& recording) {
  std::error_code ignored;
  for (const char* name : {"poses.txt", "groundtruth.tum", "state_groundtruth_estimate0/data.csv",
                           "mav0/state_groundtruth_estimate0/data.csv"}) {
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
