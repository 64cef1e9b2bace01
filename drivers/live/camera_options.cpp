// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/live/camera_options.h"

#include "drivers/calibration_file.h"
#include "drivers/images/masks.h"

namespace cliquevo::drivers {

namespace {

Error bad(const char* key, const char* remedy) { return {"configuration value out of range", key, remedy}; }

}  // namespace

Result<void> CameraOptions::check_names() const {
  if (left.empty()) return bad("left", "name a camera (`cliquevo cameras` lists them)");
  if (layout == CameraLayout::two_cameras && right.empty()) return bad("right", "name the right camera");
  if (layout == CameraLayout::two_cameras && right == left)
    return bad("right", "name another camera than the left one");
  if (needs_calibration && calibration.empty()) return bad("calibration", "name the cameras' calibration");
  return {};
}

Result<void> CameraOptions::check() const {
  if (auto ok = calibration_options.check(); !ok) return ok;
  if (!(rate_hz >= 0.1 && rate_hz <= 1000.0)) return bad("rate_hz", "give 0.1 to 1000");
  if (width < 0 || width > 16384) return bad("width", "give 0 (as it is) to 16384");
  if (height < 0 || height > 16384) return bad("height", "give 0 (as it is) to 16384");
  if (offset_x < 0 || offset_x > 16384) return bad("offset_x", "give 0 to 16384");
  if (offset_y < 0 || offset_y > 16384) return bad("offset_y", "give 0 to 16384");
  if (binning < 1 || binning > 16) return bad("binning", "give 1 to 16");
  if (exposure_us && !(*exposure_us > 0.0 && *exposure_us <= 1e7)) return bad("exposure_us", "give more than 0");
  if (!(exposure_max_us >= 0.0 && exposure_max_us <= 1e7)) return bad("exposure_max_us", "give 0 (no limit) or more");
  if (packet_size < 0 || packet_size > 65535) return bad("packet_size", "give 0 (as large as gets through) to 65535");
  return {};
}

Result<void> check_live_calibration(const CameraOptions& options) {
  if (!options.needs_calibration) return {};
  // Some formats do not hold the size: they fit any.
  constexpr int kAnyWidth = 640;
  constexpr int kAnyHeight = 480;
  const auto calibration = read_calibration(options.calibration, options.width, options.height);
  if (calibration || (options.width > 0 && options.height > 0)) {
    return calibration ? Result<void>() : calibration.error();
  }
  return read_calibration(options.calibration, kAnyWidth, kAnyHeight) ? Result<void>() : calibration.error();
}

Result<SourceInfo> live_source_info(const CameraOptions& options, int width, int height,
                                    const std::string& description) {
  SourceInfo info;
  info.description = description;
  info.width = width;
  info.height = height;
  info.rate_hz = options.rate_hz;
  info.live = true;
  if (options.needs_calibration) {
    auto calibration = read_calibration(options.calibration, width, height, options.calibration_options);
    if (!calibration) return calibration.error();
    info.calibration = std::move(*calibration);
  }
  if (auto ok = read_masks(options.left_mask, options.right_mask, "", info); !ok) return ok.error();
  return info;
}

}  // namespace cliquevo::drivers
