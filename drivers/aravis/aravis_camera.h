// SPDX-License-Identifier: BSD-3-Clause
// One camera through Aravis: opened, set up and streaming.
#pragma once

#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "core/base/image.h"
#include "core/base/result.h"
#include "drivers/aravis/aravis_samples.h"
#include "drivers/aravis/handles.h"
#include "drivers/images/bayer.h"
#include "drivers/live/camera_options.h"
#include "drivers/live/exposure_control.h"

namespace cliquevo::drivers {

// A frame that was taken from the stream; its pixels are valid until it is given back.
struct AravisFrame {
  ArvBuffer* buffer = nullptr;
  bool whole = false;
  TimestampNs stamp_ns = 0;
  ImageView<const std::uint8_t> image;
};

class AravisCamera {
 public:
  // follows: takes exposure and gain from the other camera where these are automatic. trouble: set with an error.
  static Result<AravisCamera> open(const std::string& name, const CameraOptions& options, bool follows,
                                   OpenTrouble& trouble);
  AravisCamera(AravisCamera&&) noexcept;
  AravisCamera& operator=(AravisCamera&&) = delete;
  ~AravisCamera();

  int width() const { return width_; }
  int height() const { return height_; }
  Result<void> start();
  // nullopt: nothing within timeout_us.
  std::optional<AravisFrame> take(std::uint64_t timeout_us);
  void give_back(const AravisFrame& frame);
  bool lost() const { return lost_->load(std::memory_order_relaxed); }
  void trigger();
  // The present exposure time [us] and gain; nullopt: cannot be read.
  std::optional<double> exposure_us();
  std::optional<double> gain();
  void set_exposure_us(double value);
  void set_gain(double value);
  // Where the exposure time has a limit that the camera's own control does not know: from a picture of the leader, what
  // to set next. false: the camera looks after itself.
  bool controls_exposure() const { return exposure_range_.has_value(); }
  void control_exposure(ImageView<const std::uint8_t> image);

 private:
  AravisCamera() = default;
  Result<void> set_up(const CameraOptions& options, bool follows);
  Result<void> set_up_exposure(const CameraOptions& options, bool follows);
  Result<void> limit_exposure(double limit_us);
  Result<void> set_up_trigger(const CameraOptions& options);
  Result<void> choose_format(const std::string& wanted);
  Result<void> open_stream(const CameraOptions& options);
  Result<void> guard(std::size_t payload_bytes);
  bool answers();
  Error refused(const char* what, const std::string& why) const;
  void convert(AravisFrame& frame, const std::uint8_t* data, std::size_t size);

  std::string name_;
  Handle<ArvCamera> camera_;
  Handle<ArvStream> stream_;
  std::unique_ptr<std::atomic<bool>> lost_ = std::make_unique<std::atomic<bool>>(false);
  bool started_ = false;
  int width_ = 0;
  int height_ = 0;
  AravisSamples samples_{8, {}, false};
  MosaicToGrey to_grey_;
  Image<std::uint8_t> converted_;
  std::optional<ExposureRange> exposure_range_;  // of a control of our own
};

// Whether the camera has the feature of this name, at present.
bool has_feature(ArvCamera* camera, const char* feature);

// Packets that wait too long are lost: real-time priority for the calling thread, as far as it is granted.
void hurry_this_thread();

// A camera's settings for a trigger; apart, so that they can be tested without cameras.
struct FeatureSetting {
  std::string feature;
  std::string value;  // text, or a number
  bool operator==(const FeatureSetting&) const = default;
};
std::vector<FeatureSetting> trigger_settings(const CameraOptions& options);
// Settings of the stream and of the clock.
struct StreamRequest {
  unsigned packet_timeout_us = 0;  // without a packet until one is requested again
  unsigned frame_retention_us = 0;
  bool resend = false;
  bool operator==(const StreamRequest&) const = default;
};
StreamRequest stream_request(const CameraOptions& options);
// The feature that turns PTP on: the standard's present name where the camera has it, or the older one.
const char* ptp_feature(bool has_present_name);
// The packet that triggers all cameras which listen to these keys (GVCP ACTION_CMD).
std::vector<std::uint8_t> action_command(std::uint16_t request_id);

}  // namespace cliquevo::drivers
