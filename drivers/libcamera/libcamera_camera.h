// SPDX-License-Identifier: BSD-3-Clause
// One camera through libcamera: configured, with its buffers mapped and its requests queued again and again.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "drivers/libcamera/compatibility.h"
#include "drivers/live/camera_options.h"
#include "drivers/live/exposure_control.h"
#include "drivers/pixels/pixels.h"

namespace cliquevo::drivers {

struct LibcameraFrame {
  RawFrame raw;  // while the call lasts
  TimestampNs stamp_utc_ns = 0;
  TimestampNs arrival_utc_ns = 0;
  std::int64_t arrival_mono_ns = 0;
  std::int64_t sequence = 0;  // the driver's count
  bool whole = false;
  ExposureSetting taken_with;  // 0 = unknown
};

class LibcameraCamera {
 public:
  // on_frame is called on libcamera's thread. trouble: set with an error.
  static Result<std::unique_ptr<LibcameraCamera>> open(const std::string& id, const CameraOptions& options,
                                                       std::function<void(const LibcameraFrame&)> on_frame,
                                                       OpenTrouble& trouble);
  ~LibcameraCamera();
  LibcameraCamera(const LibcameraCamera&) = delete;
  LibcameraCamera& operator=(const LibcameraCamera&) = delete;

  int width() const { return width_; }
  int height() const { return height_; }
  std::uint32_t fourcc() const { return fourcc_; }
  Result<void> start();
  // Why something was refused just now: whether it is still there.
  OpenTrouble trouble() const;
  bool lost() const { return lost_; }
  std::int64_t last_frame_mono_ns() const { return last_frame_mono_ns_; }
  // What the sensor's last frame was taken with; 0 = unknown.
  std::int32_t exposure_us() const { return exposure_us_; }
  float gain() const { return gain_; }
  // Where the exposure time has a limit: what a control of ours chooses from; the camera's own is off then.
  const std::optional<ExposureRange>& exposure_range() const { return exposure_range_; }
  // For the frames to come.
  void follow(std::int32_t exposure_us, float gain);

 private:
  LibcameraCamera() = default;
  Result<void> configure(const CameraOptions& options);
  Result<void> map_buffers();
  Result<void> set_controls(const CameraOptions& options);
  Result<void> limit_exposure(const CameraOptions& options);
  void completed(libcamera::Request* request);
  void disconnected() { lost_ = true; }
  Error refused(const std::string& what) const;

  struct Mapped {
    std::uint8_t* data = nullptr;
    std::size_t size = 0;
    std::size_t offset = 0;
  };
  std::string id_;
  std::function<void(const LibcameraFrame&)> on_frame_;
  std::shared_ptr<libcamera::Camera> camera_;
  std::unique_ptr<libcamera::CameraConfiguration> configuration_;
  std::unique_ptr<libcamera::FrameBufferAllocator> allocator_;
  std::map<const libcamera::FrameBuffer*, Mapped> mapped_;
  std::vector<std::unique_ptr<libcamera::Request>> requests_;
  libcamera::ControlList controls_;
  std::optional<ExposureRange> exposure_range_;
  bool acquired_ = false;
  bool started_ = false;
  int width_ = 0;
  int height_ = 0;
  std::size_t stride_ = 0;
  std::uint32_t fourcc_ = 0;
  std::atomic<bool> stopping_{false};
  std::atomic<bool> lost_{false};
  std::atomic<std::int64_t> last_frame_mono_ns_{0};
  std::atomic<std::int32_t> exposure_us_{0};
  std::atomic<float> gain_{0.0F};
  std::atomic<std::int32_t> follow_exposure_us_{0};
  std::atomic<float> follow_gain_{0.0F};
};

// The process's one camera manager; nullptr when it does not start.
libcamera::CameraManager* camera_manager();

}  // namespace cliquevo::drivers
