// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/config.h"

#include <numbers>

#include <fmt/format.h>

#include "daemon/pipeline/keys/keys.h"

namespace cliquevo::daemon {

namespace {

// A room's parameters name their fields; in the file they stand in a section.
Result<void> in_section(const char* section, const Result<void>& checked) {
  if (checked) return {};
  const Error& error = checked.error();
  return Error{error.what, fmt::format("{}.{}", section, error.where), error.remedy};
}

Error out_of_range(const char* key, const char* remedy) { return {"configuration value out of range", key, remedy}; }

}  // namespace

RigidTransform Mounting::T_body_camera() const {
  constexpr double kRadian = std::numbers::pi / 180.0;
  RigidTransform T;
  Eigen::Matrix3d R_forward;  // camera axes of a camera that looks forward: X right, Y down, Z forward
  R_forward << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  T.R = (Eigen::AngleAxisd(kRadian * roll_pitch_yaw_deg.z(), Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(kRadian * roll_pitch_yaw_deg.y(), Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(kRadian * roll_pitch_yaw_deg.x(), Eigen::Vector3d::UnitX()))
            .toRotationMatrix() *
        R_forward;
  T.t = translation_m;
  return T;
}

Config default_config() {
  Config config;
  config.stereo.workers = 2;  // the library's default is one thread; a vehicle needs the pose soon
  config.T_body_camera = config.body.T_body_camera();
  return config;
}

// Each key's own range is in its row; rules that involve several keys are here and in the rooms' own checks.
Result<void> Config::check() const {
  Config checked = *this;
  const KeyTable table = config_keys(checked);
  for (const Key& key : table.keys()) {
    if (auto ok = key.check(); !ok) return ok;
  }
  const auto& played = source.recording;
  if (played.last >= 0 && played.last < played.first) {
    return out_of_range("source.recording.last", "give -1 (the last there is), or a pair not before the first");
  }
  if (source.type == "recording" && played.path.empty()) {
    return out_of_range("source.recording.path", "name the recording's folder");
  }
  if (recording.at_start && recording.folder.empty()) {
    return out_of_range("recording.folder", "name a folder to record into");
  }
  if (auto ok = in_section("source.recording", played.calibration_options.check()); !ok) return ok;
  if (auto ok = in_section("source.cameras", source.cameras.check()); !ok) return ok;
  if (source.is_live()) {
    if (auto ok = in_section("source.cameras", source.cameras.check_names()); !ok) return ok;
  }
  if (auto ok = in_section("rectify", rectify.check()); !ok) return ok;
  if (auto ok = in_section("stereo", stereo.check()); !ok) return ok;
  if (auto ok = in_section("odometry", odometry.check()); !ok) return ok;
  return in_section("source.simulator", source.simulator.check());
}

std::vector<std::pair<std::string, std::string>> list_config(const Config& config) {
  Config listed = config;
  std::vector<std::pair<std::string, std::string>> out;
  const KeyTable table = config_keys(listed);
  for (const Key& key : table.keys()) out.emplace_back(key.name, key.value());
  return out;
}

}  // namespace cliquevo::daemon
