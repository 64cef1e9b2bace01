// SPDX-License-Identifier: BSD-3-Clause
// cliquevo._core, the compiled part of the Python package.
#include "tools/python/bind.h"

PYBIND11_MODULE(_core, module) {
  using namespace cliquevo::python;
  module.doc() = "Stereo visual odometry: the compiled part of the package cliquevo.";
  module.attr("__version__") = CLIQUEVO_VERSION;
  bind_errors(module);
  bind_cameras(module);
  bind_stereo(module);
  bind_odometry(module);
  bind_sources(module);
  bind_trajectory(module);
  bind_log(module);
}
