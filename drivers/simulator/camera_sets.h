// SPDX-License-Identifier: BSD-3-Clause
// Cameras by name: sets of the effects in rough_camera.h and sensor.h.
#pragma once

#include <string>

#include "drivers/simulator.h"

namespace cliquevo::drivers::sim {

bool is_camera_set(const std::string& name);
// "clean, webcam, ..."
std::string camera_set_names();

// The size and focal length of the set `options.camera`, over what was there.
void take_camera_size(SimulatorOptions& options);

// Values of -1 become those of the set options.camera.
SimulatorOptions with_camera(SimulatorOptions options);

}  // namespace cliquevo::drivers::sim
