// SPDX-License-Identifier: BSD-3-Clause
// The configuration file (config/cliquevo.yaml): every key has a default; an unknown key is an error with file and
// line. keys/ holds the table of keys.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "core/base/result.h"
#include "core/base/rigid_transform.h"
#include "core/vo/vo_params.h"
#include "daemon/pipeline/lcm_config.h"
#include "drivers/live/camera_options.h"
#include "drivers/recording/recording_options.h"
#include "drivers/simulator.h"
#include "stereo/rectify_params.h"
#include "stereo/stereo_params.h"

namespace cliquevo::daemon {

struct SourceConfig {
  std::string type = "simulator";  // simulator, recording, or a family of cameras
  drivers::SimulatorOptions simulator;
  drivers::RecordingOptions recording;
  drivers::CameraOptions cameras;
  std::string loop = "none";  // none, pingpong (recordings: forward, then backward, without end)
  bool swap_eyes = false;     // left and right come exchanged, in files or cabling
  double speed = 1.0;         // times recorded pace; 0 = as fast as possible

  bool is_live() const { return type != "simulator" && type != "recording"; }
};

// The Unix socket that commands come through.
struct ControlConfig {
  std::string socket = "/run/cliquevo/control";  // empty = none
};

// What the daemon requests of the machine. Missing rights are reported once, and it runs without them.
struct RealtimeConfig {
  bool lock_memory = true;     // keep all memory in RAM
  int stereo_cpu = -1;         // core of the stereo thread, -1 = any
  int odometry_cpu = -1;       //
  int worker_cpu = -1;         // of the stereo thread's first helper; further ones on the cores after it
  int stereo_priority = 50;    // SCHED_FIFO, 1 to 99; 0 = ordinary time sharing
  int odometry_priority = 50;  //
  int output_priority = 30;    // below them: sending may block
  int catch_up_frames = 20;    // rt::Handover's backlog
};

// Logs that the daemon writes: pairs as grabbed, calibration, and the messages that it sends.
struct RecordingConfig {
  std::string folder;                 // empty = no recording
  bool at_start = false;              // from the start on; else by a command
  std::int64_t max_file_mb = 1024;    // a new file when this one has so many
  std::int64_t max_total_mb = 16384;  // of all logs in the folder that the daemon wrote: the oldest go
  std::int64_t queue_mb = 64;         // memory for what waits for the disk
};

// How the camera sits on the vehicle: rectified left camera in the body frame (X forward, Y left, Z up). All zero: at
// the body's origin, level, looking forward. Angles turn about the body's axes by the right hand, roll first, yaw last:
// a positive pitch looks down, a positive yaw to the left.
struct Mounting {
  Eigen::Vector3d translation_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d roll_pitch_yaw_deg = Eigen::Vector3d::Zero();

  RigidTransform T_body_camera() const;
};

struct Config {
  SourceConfig source;
  stereo::RectifyParams rectify;
  stereo::StereoParams stereo;
  vo::VoParams odometry;
  LcmConfig lcm;
  ControlConfig control;
  RealtimeConfig realtime;
  Mounting body;
  RecordingConfig recording;
  RigidTransform T_body_camera;    // of `body`
  std::string log_level = "info";  // trace, debug, info, warn, error

  // An error's `where` begins with the key at fault, as in the file: "stereo.window = 4".
  Result<void> check() const;
};

// Where a configuration comes from; what comes later wins.
struct ConfigSources {
  std::vector<std::string> files;
  std::vector<std::string> settings;  // "section.key=value" of the command line
  bool needs_calibration = true;      // of cameras; false: for those who make one

  bool empty() const { return files.empty() && settings.empty(); }
};

// The compiled defaults.
Config default_config();
// The defaults with what the files and then the settings say. Relative paths start from their file's own folder; those
// of settings from the working one.
Result<Config> read_config(const ConfigSources& sources);
Result<Config> read_config(const std::string& path);
// The same of a text; path: for messages, and where relative paths start.
Result<Config> parse_config(const std::string& text, const std::string& path);

// Every key with its value as the file would have it, in the file's order.
std::vector<std::pair<std::string, std::string>> list_config(const Config& config);

}  // namespace cliquevo::daemon
