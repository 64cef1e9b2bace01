// SPDX-License-Identifier: BSD-3-Clause
// From a noise-free image to what a camera delivers: exposure, shot and read noise, 8 bits.
#pragma once

#include <cstdint>

#include "core/base/image.h"
#include "drivers/simulator.h"

namespace cliquevo::drivers::sim {

// During which the picture is blurred by motion.
inline constexpr double kExposureS = 0.003;

// Of both cameras: a slow drift, and steps as an automatic exposure takes them. About 0.8 to 1.2.
double exposure_gain(const SimulatorOptions& options, std::int64_t frame);

void expose(const SimulatorOptions& options, std::int64_t frame, int side, ImageView<const std::uint16_t> clean,
            Image<std::uint8_t>& out);

}  // namespace cliquevo::drivers::sim
