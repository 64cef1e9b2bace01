// SPDX-License-Identifier: BSD-3-Clause
// A picture as it comes out of a camera that compresses.
#pragma once

#include <cstdint>

#include "core/base/image.h"
#include "drivers/simulator.h"

namespace cliquevo::drivers::sim {

// Of this frame and camera (0 left, 1 right): 0 = not compressed, else 1 to 100.
int jpeg_quality_of(const SimulatorOptions& options, std::int64_t frame, int camera);

// Compresses and decompresses with libjpeg (baseline, grey; its exact integer transform, so the same bits everywhere).
Result<void> through_jpeg(int quality, Image<std::uint8_t>& image);

}  // namespace cliquevo::drivers::sim
