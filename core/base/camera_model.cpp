// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/camera_model.h"

#include <cmath>

namespace cliquevo {

namespace {

Error bad(const char* what) {
  return {"impossible stereo calibration", what, "calibrate the cameras again or name the right calibration file"};
}

}  // namespace

Result<void> StereoModel::check() const {
  for (const double v : {fx_px, fy_px, cx_px, cy_px, baseline_m, doffs_px}) {
    if (!std::isfinite(v)) return bad("a value is not finite");
  }
  if (width < 16 || height < 16 || width > 16384 || height > 16384) return bad("image size out of 16 to 16384 px");
  if (fx_px <= 0.0 || fy_px <= 0.0) return bad("focal length is not positive");
  if (baseline_m <= 0.0) return bad("baseline is not positive (are the cameras swapped?)");
  if (fx_px < 0.05 * width || fx_px > 100.0 * width) return bad("focal length does not fit the image width");
  if (fy_px < 0.05 * width || fy_px > 100.0 * width) return bad("vertical focal length does not fit the image");
  if (baseline_m > 100.0) return bad("baseline above 100 m (millimetres taken for metres?)");
  if (std::abs(cx_px) > 4.0 * width || std::abs(cy_px) > 4.0 * height) return bad("principal point far off the image");
  return {};
}

double StereoModel::horizontal_fov_rad() const {
  return std::atan2(cx_px, fx_px) + std::atan2(width - 1 - cx_px, fx_px);
}

double StereoModel::vertical_fov_rad() const {
  return std::atan2(cy_px, fy_px) + std::atan2(height - 1 - cy_px, fy_px);
}

}  // namespace cliquevo
