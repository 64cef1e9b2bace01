// SPDX-License-Identifier: BSD-3-Clause
// Cameras of libcamera as pairs, before anything is known of their calibration.
#pragma once

#include <atomic>
#include <memory>
#include <string>
#include <thread>

#include "drivers/libcamera/libcamera_camera.h"
#include "drivers/live/camera_options.h"
#include "drivers/live/live_pairs.h"

namespace cliquevo::drivers {

class LibcameraPairs {
 public:
  static Result<std::unique_ptr<LibcameraPairs>> open(const CameraOptions& options, OpenTrouble& trouble);
  ~LibcameraPairs();
  LibcameraPairs(const LibcameraPairs&) = delete;
  LibcameraPairs& operator=(const LibcameraPairs&) = delete;

  int width() const { return width_; }
  int height() const { return height_; }
  bool next(StereoPair& pair) { return pairs_->next(pair); }
  void interrupt() { pairs_->interrupt(); }
  std::string status() const { return pairs_->status(); }
  std::string queues() const { return pairs_->queues(); }

 private:
  explicit LibcameraPairs(const CameraOptions& options) : options_(options) {}
  Result<std::unique_ptr<LibcameraCamera>> open_camera(CameraSide side, OpenTrouble& trouble);
  void hand_on(CameraSide side, const LibcameraFrame& frame);
  void control_exposure(const LibcameraFrame& frame);
  void share_exposure();
  void watch();

  CameraOptions options_;
  int width_ = 0;
  int height_ = 0;
  std::uint32_t fourcc_ = 0;
  std::unique_ptr<LivePairs> pairs_;
  Image<std::uint8_t> grey_[2][2];               // libcamera's thread's: of each camera, half of its frame
  std::unique_ptr<LibcameraCamera> cameras_[2];  // once it runs, the watching thread's
  std::optional<ExposureRange> exposure_range_;  // of a control of our own
  ExposureSetting wanted_;                       // libcamera's thread's
  std::int64_t next_control_ns_ = 0;             // likewise
  std::atomic<std::int32_t> wanted_exposure_us_{0};
  std::atomic<float> wanted_gain_{0.0F};
  std::atomic<bool> stop_{false};
  std::thread watcher_;
};

}  // namespace cliquevo::drivers
