// SPDX-License-Identifier: BSD-3-Clause
// What goes wrong between the lens and the program, done to the finished images.
#pragma once

#include <cstdint>

#include "core/base/image.h"
#include "drivers/simulator.h"

namespace cliquevo::drivers::sim {

// Whether options.fault is on at this frame of the render.
bool fault_active(const SimulatorOptions& options, std::int64_t frame);

// The frame whose image this camera delivers: a camera that is frozen keeps the last one before the fault.
std::int64_t delivered_frame(const SimulatorOptions& options, std::int64_t frame, int side);

// Factor on the light that the sensor gets.
double fault_gain(const SimulatorOptions& options, std::int64_t frame);

// blank, noise, covered, flare: over the exposed image.
void apply_fault(const SimulatorOptions& options, std::int64_t frame, int side, Image<std::uint8_t>& image);

}  // namespace cliquevo::drivers::sim
