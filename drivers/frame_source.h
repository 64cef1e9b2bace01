// SPDX-License-Identifier: BSD-3-Clause
// What every camera, recording or simulator looks like to the rest of the program.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "core/base/camera_model.h"
#include "core/base/image.h"
#include "core/base/result.h"
#include "core/base/time.h"

namespace cliquevo::drivers {

struct StereoPair {
  std::int64_t index = 0;    // position in the source; rises strictly
  TimestampNs stamp_ns = 0;  // exposure (the left camera's where the cameras differ)
  Image<std::uint8_t> left;  // grey, as grabbed
  Image<std::uint8_t> right;
  std::int64_t right_offset_ns = 0;                    // right exposure - left exposure, where known
  TimestampNs host_ns = 0;                             // arrival on this machine, UTC; 0 = not known
  std::optional<RigidTransform> truth_T_world_camera;  // rectified left camera in its first frame, where known exactly
};

struct SourceInfo {
  std::string description;  // "KITTI odometry folder /data/06"
  int width = 0;            // of the raw images
  int height = 0;
  std::int64_t frame_count = -1;  // -1: live, endless
  double rate_hz = 0.0;           // nominal; 0 = unknown
  std::int64_t first_number = 0;  // of a recording's first image, where the images are numbered one by one
  bool live = false;              // frames come when they come: nobody may hold them back
  StereoCalibration calibration;
  Image<std::uint8_t> left_mask;  // raw size, 0 = the vehicle's own parts; empty = none
  Image<std::uint8_t> right_mask;
  // How the rectified left camera sits on the vehicle (X forward, Y left, Z up), where the source knows it.
  std::optional<RigidTransform> T_body_camera;
};

class FrameSource {
 public:
  virtual ~FrameSource() = default;
  virtual const SourceInfo& info() const = 0;
  // Next pair into `pair` (whose storage is reused). true: a pair; false: the source is at its end. An Error is final
  // for this pair (torn image, unequal sizes): the caller decides whether to go on.
  virtual Result<bool> next(StereoPair& pair) = 0;
  // Any thread: a next() that waits for frames, and every later one, returns false soon.
  virtual void interrupt() {}
  // Any thread: one line on the state of a live source ("left camera lost: reconnecting"); empty = nothing to report.
  virtual std::string status() const { return ""; }
  // Any thread: one line on what the images show to be wrong with the source (left and right exchanged), for the user
  // to put right; empty = nothing.
  virtual std::string finding() const { return ""; }
  // Any thread: one line on how deep a live source's queues have been; empty = it has none.
  virtual std::string queues() const { return ""; }
};

}  // namespace cliquevo::drivers
