// SPDX-License-Identifier: BSD-3-Clause
// One capture device of Video4Linux: opened, set up and streaming into mapped buffers.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "drivers/live/camera_options.h"
#include "drivers/live/exposure_control.h"
#include "drivers/pixels/pixels.h"

namespace cliquevo::drivers {

enum class V4l2Taken {
  frame,
  nothing,     // within the time
  incomplete,  // a frame that the driver marks as broken
  lost,        // the device is gone or its stream has failed: open it again
};

struct V4l2Frame {
  RawFrame raw;                  // until the next take()
  TimestampNs stamp_utc_ns = 0;  // middle of the exposure as far as the driver knows
  TimestampNs arrival_utc_ns = 0;
  std::int64_t arrival_mono_ns = 0;
  std::int64_t sequence = 0;  // the driver's count
};

class V4l2Camera {
 public:
  // follows: its own exposure control stays off; it takes what the other camera found.
  // trouble: set with an error.
  static Result<V4l2Camera> open(const std::string& path, const CameraOptions& options, bool follows,
                                 OpenTrouble& trouble);
  V4l2Camera(V4l2Camera&& other) noexcept;
  V4l2Camera& operator=(V4l2Camera&&) = delete;
  ~V4l2Camera();

  int width() const { return width_; }
  int height() const { return height_; }
  std::uint32_t fourcc() const { return fourcc_; }
  Result<void> start();
  V4l2Taken take(int timeout_ms, V4l2Frame& frame);

  std::optional<std::int32_t> control(std::uint32_t id) const;
  bool set_control(std::uint32_t id, std::int32_t value) const;
  // Where the exposure time has a limit: from a picture of the leader, what to set next.
  bool controls_exposure() const { return exposure_range_.has_value(); }
  void control_exposure(ImageView<const std::uint8_t> image);
  // Names as `v4l2-ctl` has them: small letters and underscores.
  std::vector<std::pair<std::string, std::uint32_t>> list_controls() const;

 private:
  V4l2Camera() = default;
  Error refused(const std::string& what) const;
  Result<void> set_up(const CameraOptions& options, bool follows);
  Result<void> choose_format(const CameraOptions& options);
  Result<void> set_rate(double rate_hz) const;
  Result<void> set_controls(const CameraOptions& options, bool follows);
  Result<void> set_named_controls(const std::string& controls) const;
  Result<void> limit_exposure(const CameraOptions& options);
  Result<void> map_buffers();
  bool give_back(std::uint32_t index) const;
  TimestampNs stamp_of(std::int64_t driver_ns, std::uint32_t flags, const V4l2Frame& frame) const;

  struct Mapped {
    void* data = nullptr;
    std::size_t size = 0;
  };
  std::string path_;
  int descriptor_ = -1;
  int width_ = 0;
  int height_ = 0;
  std::size_t stride_ = 0;
  std::uint32_t fourcc_ = 0;
  std::vector<Mapped> buffers_;
  std::optional<std::uint32_t> taken_;
  std::int64_t exposure_ns_ = 0;                        // 0 = not known
  std::optional<ExposureRange> exposure_range_;         // of a control of our own
  mutable OpenTrouble trouble_ = OpenTrouble::lasting;  // of the last refusal
};

// ioctl(), again when a signal cut it short.
int control_device(int descriptor, unsigned long request, void* argument);

// What a failed system call on a camera's node means for who would wait: EBUSY that it is held, ENODEV and the like
// that it is not there or falling off its bus.
OpenTrouble trouble_of(int error_number);

// The formats that a device offers.
std::vector<std::uint32_t> v4l2_formats(int descriptor);

}  // namespace cliquevo::drivers
