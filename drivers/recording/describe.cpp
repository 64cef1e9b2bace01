// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/describe.h"

#include <fmt/format.h>

#include "core/base/printable.h"

namespace cliquevo::drivers {

std::string describe_geometry(const StereoModel& m, double sigma_disparity_px) {
  constexpr double kDegrees = 57.295779513082320877;
  std::string out = fmt::format(
      "camera: baseline {:.4f} m, focal length {:.2f} px, field of view {:.1f} x {:.1f} deg, {}x{}", m.baseline_m,
      m.fx_px, m.horizontal_fov_rad() * kDegrees, m.vertical_fov_rad() * kDegrees, m.width, m.height);
  out += fmt::format("\ndepth error for {:.2f} px of disparity:", sigma_disparity_px);
  const char* separator = " ";
  for (const double z_m : {5.0, 10.0, 20.0}) {
    out += fmt::format("{}{:.3f} m at {:.0f} m", separator, m.depth_error_m(z_m, sigma_disparity_px), z_m);
    separator = ", ";
  }
  return out;
}

std::string describe_source(const SourceInfo& info) {
  std::string out = fmt::format("source: {}, {}x{}", info.description, info.width, info.height);
  if (info.frame_count >= 0) out += fmt::format(", {} pairs", info.frame_count);
  if (info.rate_hz > 0.0) out += fmt::format(", {:.2f} Hz", info.rate_hz);
  out += info.calibration.rectified ? ", rectified" : ", as grabbed";
  if (!info.calibration.source.empty()) out += ", calibration " + info.calibration.source;
  if (!info.left_mask.empty() || !info.right_mask.empty()) out += ", masked";
  return printable(out);  // names of files and cameras
}

}  // namespace cliquevo::drivers
