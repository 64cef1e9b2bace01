// SPDX-License-Identifier: BSD-3-Clause
// The parts of the module; each adds its classes and functions.
#pragma once

#include "tools/python/errors.h"

namespace cliquevo::python {

void bind_cameras(py::module_& module);     // StereoModel, Camera, StereoCalibration, read_calibration
void bind_stereo(py::module_& module);      // Rectifier, DenseStereo
void bind_odometry(py::module_& module);    // Status, Estimate, Odometry
void bind_sources(py::module_& module);     // open, Source, Pair, simulate
void bind_trajectory(py::module_& module);  // read_trajectory, write_trajectory, evaluate
void bind_log(py::module_& module);         // Log, Event

}  // namespace cliquevo::python
