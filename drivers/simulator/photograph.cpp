// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/photograph.h"

#include <cmath>

#include "drivers/simulator/fault.h"
#include "drivers/simulator/jpeg.h"
#include "drivers/simulator/sensor.h"

namespace cliquevo::drivers::sim {

TimestampNs stamp_of(const SimulatorOptions& options, std::int64_t frame) {
  return kEpochNs + static_cast<TimestampNs>(std::llround(static_cast<double>(frame) * 1e9 / options.rate_hz));
}

Result<void> photograph(const SimulatorOptions& options, const Course& course, std::int64_t frame, int camera,
                        ImageView<const std::uint16_t> clean, RoughScratch& scratch, Image<std::uint8_t>& out) {
  const std::int64_t taken = delivered_frame(options, frame, camera);
  expose(options, taken, camera, roughen(options, course, taken, camera, clean, scratch), out);
  apply_fault(options, frame, camera, out);
  const int quality = jpeg_quality_of(options, taken, camera);
  return quality > 0 ? through_jpeg(quality, out) : Result<void>();
}

}  // namespace cliquevo::drivers::sim
