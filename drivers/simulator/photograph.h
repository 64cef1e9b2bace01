// SPDX-License-Identifier: BSD-3-Clause
// From the noise-free picture of a frame to what a camera hands over.
#pragma once

#include <cstdint>

#include "core/base/image.h"
#include "drivers/simulator.h"
#include "drivers/simulator/course.h"
#include "drivers/simulator/rough_camera.h"

namespace cliquevo::drivers::sim {

// Of frame 0.
inline constexpr TimestampNs kEpochNs = 1'700'000'000'000'000'000;
TimestampNs stamp_of(const SimulatorOptions& options, std::int64_t frame);

// camera: 0 left, 1 right.
Result<void> photograph(const SimulatorOptions& options, const Course& course, std::int64_t frame, int camera,
                        ImageView<const std::uint16_t> clean, RoughScratch& scratch, Image<std::uint8_t>& out);

}  // namespace cliquevo::drivers::sim
