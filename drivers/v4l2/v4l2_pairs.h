// SPDX-License-Identifier: BSD-3-Clause
// Cameras of Video4Linux as pairs, before anything is known of their calibration: a thread a camera keeps it
// streaming, whatever happens.
#pragma once

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "drivers/live/camera_options.h"
#include "drivers/live/live_pairs.h"
#include "drivers/v4l2/v4l2_camera.h"

namespace cliquevo::drivers {

class V4l2Pairs {
 public:
  // Opens what the options name. trouble: set with an error.
  static Result<std::unique_ptr<V4l2Pairs>> open(const CameraOptions& options, OpenTrouble& trouble);
  ~V4l2Pairs();
  V4l2Pairs(const V4l2Pairs&) = delete;
  V4l2Pairs& operator=(const V4l2Pairs&) = delete;

  int width() const { return width_; }  // of an image
  int height() const { return height_; }
  bool next(StereoPair& pair) { return pairs_.next(pair); }
  void interrupt();
  std::string status() const { return pairs_.status(); }
  std::string queues() const { return pairs_.queues(); }

 private:
  V4l2Pairs(const CameraOptions& options, const PairSyncOptions& sync, std::vector<V4l2Camera> cameras, int width,
            int height);
  void run(CameraSide side, V4l2Camera first);
  bool stream(CameraSide side, V4l2Camera& camera);
  bool hand_on(CameraSide side, const V4l2Frame& frame);
  void share_exposure(CameraSide side, const V4l2Camera& camera);

  CameraOptions options_;
  int width_;
  int height_;
  LivePairs pairs_;
  std::atomic<std::int32_t> exposure_{0};  // of the left camera's control, for the right one; 0 = not known
  std::atomic<std::int32_t> gain_{-1};
  struct Grey {
    Image<std::uint8_t> left;
    Image<std::uint8_t> right;
  };
  Grey grey_[2];  // a camera's thread's
  std::mutex mutex_;
  std::condition_variable changed_;
  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
};

}  // namespace cliquevo::drivers
