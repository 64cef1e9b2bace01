// SPDX-License-Identifier: BSD-3-Clause
#include "tools/python/arguments.h"

#include <cmath>

namespace cliquevo::python {

namespace {

// So that the difference of two stamps is a number of nanoseconds too; until the year 2116.
constexpr std::int64_t kMostNs = std::int64_t{1} << 62;

std::string repr_of(const py::handle& object) { return py::cast<std::string>(py::repr(object)); }

[[noreturn]] void bad_stamp(const std::string& where, const std::string& remedy) {
  raise({"unusable time stamp", where, remedy});
}

TimestampNs whole_stamp(const py::object& stamp_ns) {
  const auto index = py::reinterpret_steal<py::object>(PyNumber_Index(stamp_ns.ptr()));
  if (!index) {
    PyErr_Clear();
    raise_type({"unusable time stamp", "stamp_ns is " + repr_of(stamp_ns), "give a whole number of nanoseconds"});
  }
  int overflow = 0;
  const long long value = PyLong_AsLongLongAndOverflow(index.ptr(), &overflow);
  if (overflow != 0 || value > kMostNs || value < -kMostNs) {
    bad_stamp("stamp_ns is " + repr_of(stamp_ns), "give nanoseconds since 1970, at most 2**62");
  }
  return value;
}

TimestampNs stamp_from_seconds(const py::object& stamp) {
  const double seconds = PyFloat_AsDouble(stamp.ptr());
  if (PyErr_Occurred() != nullptr) {
    PyErr_Clear();
    raise_type({"unusable time stamp", "stamp is " + repr_of(stamp), "give the exposure's time in seconds"});
  }
  if (!std::isfinite(seconds)) bad_stamp("stamp is " + repr_of(stamp), "give the exposure's time in seconds");
  if (std::abs(seconds) * 1e9 > static_cast<double>(kMostNs)) {
    bad_stamp("stamp is " + repr_of(stamp), "give seconds, or nanoseconds as stamp_ns=");
  }
  return std::llround(seconds * 1e9);
}

// {"stereo": {"window": 9}} of {"stereo.window": 9}.
py::dict nested(const py::dict& settings) {
  py::dict out;
  for (const auto& [key, value] : settings) {
    if (!py::isinstance<py::str>(key)) raise_type({"unusable settings", repr_of(key), "give keys like stereo.window"});
    const py::list parts = key.attr("split")(".");
    py::dict section = out;
    for (std::size_t i = 0; i + 1 < parts.size(); ++i) {
      if (!section.contains(parts[i])) section[parts[i]] = py::dict();
      const py::object next = section[parts[i]];
      if (!py::isinstance<py::dict>(next)) {
        raise({"unusable settings", repr_of(key), "a part of it is given a value already: give one of them"});
      }
      section = next;
    }
    section[parts[parts.size() - 1]] = value;
  }
  return out;
}

}  // namespace

bool is_path(const py::object& object) {
  return py::isinstance<py::str>(object) || py::isinstance<py::bytes>(object) || py::hasattr(object, "__fspath__");
}

std::string path_of(const py::object& path, const std::string& name) {
  if (!is_path(path)) raise_type({"unusable path", name + " is " + repr_of(path), "give a str or an os.PathLike"});
  const py::object bytes = py::module_::import("os").attr("fsencode")(path);
  std::string text = py::cast<std::string>(bytes);
  if (text.find('\0') != std::string::npos) raise({"unusable path", name, "give one without a NUL in it"});
  return text;
}

TimestampNs stamp_of(const py::object& stamp, const py::object& stamp_ns) {
  if (stamp.is_none() == stamp_ns.is_none()) {
    const char* where = stamp.is_none() ? "neither stamp nor stamp_ns is given" : "both stamp and stamp_ns are given";
    raise_type({"unusable time stamp", where, "give stamp in seconds or stamp_ns in nanoseconds"});
  }
  return stamp.is_none() ? whole_stamp(stamp_ns) : stamp_from_seconds(stamp);
}

daemon::Config config_of(const py::object& settings, const py::object& config) {
  if (!settings.is_none() && !config.is_none()) {
    raise_type({"unusable settings", "both settings and config are given", "put all of it into one of them"});
  }
  if (!config.is_none()) return value_of(daemon::read_config(path_of(config, "config")));
  if (settings.is_none()) return daemon::default_config();
  if (!py::isinstance<py::dict>(settings)) {
    raise_type({"unusable settings", repr_of(settings), "give a dict of keys like stereo.window"});
  }
  // JSON is YAML: the values are read, and checked, as those of a configuration file.
  const py::object text = py::module_::import("json").attr("dumps")(nested(settings));
  return value_of(daemon::parse_config(py::cast<std::string>(text), "settings"));
}

}  // namespace cliquevo::python
