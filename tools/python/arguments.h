// SPDX-License-Identifier: BSD-3-Clause
// Arguments that are no arrays: paths, time stamps, settings.
#pragma once

#include <mutex>
#include <string>
#include <utility>

#include "core/base/time.h"
#include "daemon/pipeline/config.h"
#include "tools/python/errors.h"

namespace cliquevo::python {

// str, bytes or os.PathLike, as the system's own bytes.
std::string path_of(const py::object& path, const std::string& name);
bool is_path(const py::object& object);

// stamp: seconds; stamp_ns: whole nanoseconds; exactly one of them is not None.
TimestampNs stamp_of(const py::object& stamp, const py::object& stamp_ns);

// The defaults; or those with the values of a configuration file (`config`); or with a dict of its keys
// ("stereo.window").
daemon::Config config_of(const py::object& settings, const py::object& config);

// Other Python threads run on while work() does; one thread at a time is in what the mutex guards.
template <typename Work>
auto without_gil(std::mutex& mutex, Work&& work) {
  const py::gil_scoped_release release;
  const std::lock_guard<std::mutex> lock(mutex);
  return std::forward<Work>(work)();
}

}  // namespace cliquevo::python
