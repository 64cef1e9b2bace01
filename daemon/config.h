// SPDX-License-Identifier: BSD-3-Clause
// The configuration file (config/cliquevo.yaml): every key has a default; an unknown key is an error with file and
// line.
#pragma once

#include <string>

#include "core/base/result.h"
#include "core/base/rigid_transform.h"
#include "core/vo/vo_params.h"
#include "drivers/recording.h"
#include "drivers/simulator.h"
#include "stereo/stereo_params.h"

namespace cliquevo::daemon {

struct SourceConfig {
  std::string type = "simulator";  // simulator, recording
  drivers::SimulatorOptions simulator;
  drivers::RecordingOptions recording;
  std::string loop = "none";  // none, pingpong (recordings: forward, then backward, without end)
  double speed = 1.0;         // times recorded pace; 0 = as fast as possible
};

struct LcmConfig {
  std::string url = "udpm://239.255.76.67:7667?ttl=0";
  std::string delta_channel = "VO_DELTA_CAMERA";
  std::string pose_channel = "POSE_BODY";
  std::string status_channel = "VO_STATUS";
};

struct Config {
  SourceConfig source;
  stereo::StereoParams stereo;
  vo::VoParams odometry;
  LcmConfig lcm;
  RigidTransform T_body_camera;  // mounting: rectified left camera in the body frame (X forward, Y left, Z up)

  Result<void> check() const;
};

// The compiled defaults, with T_body_camera = camera looking forward, level, at the body's origin.
Config default_config();
Result<Config> read_config(const std::string& path);

}  // namespace cliquevo::daemon
