// SPDX-License-Identifier: BSD-3-Clause
// Exposure and gain of a camera: fixed, its own control's, that with a limit, or ours.
#include <algorithm>
#include <array>

#include "drivers/aravis/aravis_camera.h"

namespace cliquevo::drivers {

namespace {

// The limit [us] of the camera's own control, by its makers' names: the standard (SFNC) has none.
constexpr std::array kLimitFeatures = {
    "AutoExposureExposureTimeUpperLimit",  // FLIR
    "AutoExposureTimeUpperLimit",          // Basler
    "AutoExposureTimeAbsUpperLimit",       // Basler, older
    "ExposureAutoUpperLimit",              // Lucid, The Imaging Source
    "mvExposureAutoUpperLimit",            // Matrix Vision
    "ExposureAutoMax",                     // Allied Vision
    "AutoExposureTimeMax",                 // Daheng
    "ExposureAutoMaxValue",                // Baumer and others
    "exposureAutoMaxValue",                // Teledyne DALSA
};
// Off, where the limit would be the camera's own choice otherwise.
constexpr std::array kLimitSwitches = {"ExposureAutoUpperLimitAuto", "ExposureAutoLimitAuto"};

}  // namespace

bool has_feature(ArvCamera* camera, const char* feature) {
  GlibError error;
  return arv_camera_is_feature_available(camera, feature, error.out()) != 0 && !error.failed();
}

// The follower's own control is off: it takes what the leader found.
Result<void> AravisCamera::set_up_exposure(const CameraOptions& options, bool follows) {
  ArvCamera* camera = camera_.get();
  GlibError error;
  exposure_range_.reset();
  if (options.exposure_max_us > 0.0 && !options.exposure_us && !follows) {
    if (auto ok = limit_exposure(options.exposure_max_us); !ok) return ok;
  }
  const bool automatic = !options.exposure_us && !follows && !exposure_range_;
  if (has_feature(camera, "ExposureAuto")) {
    arv_camera_set_exposure_time_auto(camera, automatic ? ARV_AUTO_CONTINUOUS : ARV_AUTO_OFF, error.out());
  }
  if (has_feature(camera, "GainAuto")) {
    const bool gain_automatic = !options.gain && !follows && !exposure_range_;
    arv_camera_set_gain_auto(camera, gain_automatic ? ARV_AUTO_CONTINUOUS : ARV_AUTO_OFF, error.out());
  }
  if (options.exposure_us) {
    arv_camera_set_exposure_time(camera, *options.exposure_us, error.out());
    if (error.failed()) return refused("the exposure time", error.text());
  }
  if (options.gain) {
    arv_camera_set_gain(camera, *options.gain, error.out());
    if (error.failed()) return refused("the gain", error.text());
    if (exposure_range_) exposure_range_->least.gain = exposure_range_->most.gain = *options.gain;
  }
  return {};
}

// By the camera's own control where that knows a limit; else exposure_range_ is set, for ours.
Result<void> AravisCamera::limit_exposure(double limit_us) {
  ArvCamera* camera = camera_.get();
  for (const char* feature : kLimitSwitches) {
    if (!has_feature(camera, feature)) continue;
    arv_camera_set_boolean(camera, feature, FALSE, GlibError().out());  // by type, one of the two does nothing
    arv_camera_set_string(camera, feature, "Off", GlibError().out());
  }
  for (const char* feature : kLimitFeatures) {
    if (!has_feature(camera, feature)) continue;
    GlibError failed;
    arv_camera_set_float(camera, feature, limit_us, failed.out());
    if (!failed.failed()) return {};
    GlibError also_failed;  // some have it as a whole number
    arv_camera_set_integer(camera, feature, static_cast<gint64>(limit_us), also_failed.out());
    if (!also_failed.failed()) return {};
  }
  GlibError error;
  ExposureRange range;
  arv_camera_get_exposure_time_bounds(camera, &range.least.exposure_us, &range.most.exposure_us, error.out());
  if (error.failed()) return refused("a limit of its exposure time", error.text());
  if (range.least.exposure_us > limit_us) {
    return refused("so short a limit of its exposure time", "set exposure_max_us to more");
  }
  range.most.exposure_us = std::min(range.most.exposure_us, limit_us);
  GlibError no_gain;
  arv_camera_get_gain_bounds(camera, &range.least.gain, &range.most.gain, no_gain.out());
  if (no_gain.failed()) range.least.gain = range.most.gain = 0.0;
  exposure_range_ = range;
  return {};
}

void AravisCamera::control_exposure(ImageView<const std::uint8_t> image) {
  if (!exposure_range_) return;
  const auto now_us = exposure_us();
  if (!now_us) return;
  const ExposureSetting now{*now_us, gain().value_or(0.0)};
  const ExposureSetting next = next_exposure(image, now, *exposure_range_);
  if (next.exposure_us != now.exposure_us) set_exposure_us(next.exposure_us);
  if (next.gain != now.gain) set_gain(next.gain);
}

std::optional<double> AravisCamera::exposure_us() {
  GlibError error;
  const double value = arv_camera_get_exposure_time(camera_.get(), error.out());
  return error.failed() ? std::nullopt : std::optional(value);
}

std::optional<double> AravisCamera::gain() {
  GlibError error;
  const double value = arv_camera_get_gain(camera_.get(), error.out());
  return error.failed() ? std::nullopt : std::optional(value);
}

void AravisCamera::set_exposure_us(double value) {
  arv_camera_set_exposure_time(camera_.get(), value, GlibError().out());
}

void AravisCamera::set_gain(double value) { arv_camera_set_gain(camera_.get(), value, GlibError().out()); }

}  // namespace cliquevo::drivers
