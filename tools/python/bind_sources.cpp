// SPDX-License-Identifier: BSD-3-Clause
// Recordings, logs and the simulator as Python iterators of pairs.
#include <pybind11/eigen.h>
#include <pybind11/stl.h>

#include "drivers/describe.h"
#include "drivers/simulator.h"
#include "tools/python/arguments.h"
#include "tools/python/arrays.h"
#include "tools/python/bind.h"
#include "tools/python/py_source.h"
#include "tools/simulated_recording.h"
#include "tools/source_argument.h"

namespace cliquevo::python {

namespace {

using namespace py::literals;
using drivers::StereoPair;

// "name: what is assumed" as Python warnings.
void warn(const std::string& text) {
  if (PyErr_WarnEx(PyExc_UserWarning, text_for_python(text).c_str(), 2) < 0) throw py::error_already_set();
}

std::optional<drivers::Bayer> bayer_of(const std::optional<std::string>& name) {
  if (!name) return std::nullopt;
  constexpr std::pair<const char*, drivers::Bayer> kPatterns[] = {
      {"auto", drivers::Bayer::automatic}, {"none", drivers::Bayer::none}, {"rggb", drivers::Bayer::rggb},
      {"bggr", drivers::Bayer::bggr},      {"grbg", drivers::Bayer::grbg}, {"gbrg", drivers::Bayer::gbrg}};
  for (const auto& [known, pattern] : kPatterns) {
    if (*name == known) return pattern;
  }
  raise({"unknown Bayer pattern", *name, "choose from auto, none, rggb, bggr, grbg, gbrg"});
}

std::unique_ptr<PySource> open(const py::object& source, const py::object& calibration, std::optional<double> rate_hz,
                               std::optional<std::int64_t> first, std::optional<std::int64_t> last,
                               std::optional<std::int64_t> every, std::optional<double> pair_tolerance_s,
                               const std::optional<std::string>& bayer, const std::string& channel, bool side_by_side,
                               bool swap_left_right, double baseline_unit_m, bool rectified, const std::string& lens,
                               double readout_ms, const py::object& settings, const py::object& config) {
  tools::SourceArgument argument;
  argument.text = path_of(source, "source");
  if (!calibration.is_none()) argument.calibration = path_of(calibration, "calibration");
  argument.calibration_options = {baseline_unit_m, rectified, lens, readout_ms};
  argument.rate_hz = rate_hz;
  argument.first = first;
  argument.last = last;
  argument.every = every;
  argument.pair_tolerance_s = pair_tolerance_s;
  argument.bayer = bayer_of(bayer);
  argument.channel = channel;
  argument.side_by_side = side_by_side;
  argument.swap_eyes = swap_left_right;
  argument.print_notes = false;
  check(argument.calibration_options.check());
  check(tools::check_source(argument));
  const daemon::SourceConfig read = config_of(settings, config).source;
  auto opened = [&] {
    const py::gil_scoped_release release;
    return tools::open_source(argument, read);
  }();
  auto out = std::make_unique<PySource>(value_of(std::move(opened)));
  for (const std::string& note : out->info().calibration.notes) warn("calibration: " + note);
  return out;
}

// One text of the simulator's: on or off, angles as x:y:z, anything else as it prints.
std::string option_text(const py::handle& value) {
  if (py::isinstance<py::bool_>(value)) return value.cast<bool>() ? "on" : "off";
  if (!py::isinstance<py::tuple>(value) && !py::isinstance<py::list>(value))
    return py::cast<std::string>(py::str(value));
  std::string out;
  for (const py::handle& one : value) {
    if (!out.empty()) out += ':';
    out += py::cast<std::string>(py::str(one));
  }
  return out;
}

drivers::SimulatorOptions simulator_options(const py::kwargs& keys) {
  drivers::SimulatorOptions options;
  // The camera first: whatever else is given overrides what its set has.
  for (const bool camera : {true, false}) {
    for (const auto& [key, value] : keys) {
      const auto name = py::cast<std::string>(key);
      if ((name == "camera") == camera) check(drivers::set_simulator_option(options, name, option_text(value)));
    }
  }
  check(options.check());
  return options;
}

std::int64_t simulate(const py::object& out, const py::kwargs& keys) {
  const std::string folder = path_of(out, "out");
  const drivers::SimulatorOptions options = simulator_options(keys);
  std::mutex alone;
  const auto simulator = value_of(without_gil(alone, [&] { return drivers::open_simulator(options); }));
  auto recording =
      value_of(tools::SimulatedRecording::create(folder, simulator->info().calibration, simulator->info().rate_hz));
  StereoPair pair;
  for (;;) {
    const bool more = value_of(without_gil(alone, [&]() -> Result<bool> {
      auto next = simulator->next(pair);
      if (!next || !*next) return next;
      if (auto ok = recording.add(pair, simulator->truth_disparity()); !ok) return ok.error();
      return true;
    }));
    if (!more) break;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();  // Ctrl-C
  }
  check(recording.finish());
  return simulator->info().frame_count;
}

py::object mask_of(const Image<std::uint8_t>& mask) {
  return mask.empty() ? py::object(py::none()) : py::object(copy_of(mask.cview()));
}

void bind_pair(py::module_& module) {
  py::class_<StereoPair>(module, "Pair", "Two images of one instant.")
      .def_readonly("index", &StereoPair::index)
      .def_readonly("stamp_ns", &StereoPair::stamp_ns)
      .def_property_readonly("stamp", [](const StereoPair& p) { return static_cast<double>(p.stamp_ns) * 1e-9; })
      .def_property_readonly(
          "left", [](const py::object& self) { return array_of(self.cast<const StereoPair&>().left.cview(), self); })
      .def_property_readonly(
          "right", [](const py::object& self) { return array_of(self.cast<const StereoPair&>().right.cview(), self); })
      .def_property_readonly("T_world_camera", [](const StereoPair& p) -> std::optional<Matrix4> {
        if (!p.truth_T_world_camera) return std::nullopt;
        return matrix_of(*p.truth_T_world_camera);
      });
}

}  // namespace

void bind_sources(py::module_& module) {
  bind_pair(module);
  py::class_<PySource>(module, "Source", "Pairs of a recording, a log or the simulator, in order.")
      .def("__iter__", [](const py::object& self) { return self; })
      .def("__next__",
           [](PySource& source) {
             auto pair = source.next();
             if (!pair) throw py::stop_iteration();
             return pair;
           })
      .def("__enter__", [](const py::object& self) { return self; })
      .def("__exit__", [](PySource& source, const py::args&) { source.close(); })
      .def("close", &PySource::close, "No further pairs.")
      .def_property_readonly("calibration", [](const PySource& s) { return s.info().calibration; })
      .def_property_readonly("description",
                             [](const PySource& s) { return text_for_python(drivers::describe_source(s.info())); })
      .def_property_readonly("width", [](const PySource& s) { return s.info().width; })
      .def_property_readonly("height", [](const PySource& s) { return s.info().height; })
      .def_property_readonly("rate_hz", [](const PySource& s) { return s.info().rate_hz; })
      .def_property_readonly("frame_count",
                             [](const PySource& s) -> std::optional<std::int64_t> {
                               if (s.info().frame_count < 0) return std::nullopt;
                               return s.info().frame_count;
                             })
      .def_property_readonly("left_mask", [](const PySource& s) { return mask_of(s.info().left_mask); })
      .def_property_readonly("right_mask", [](const PySource& s) { return mask_of(s.info().right_mask); })
      .def_property_readonly("finding", [](const PySource& s) { return text_for_python(s.finding()); });
  module.def("open", &open, "source"_a, py::kw_only(), "calibration"_a = py::none(), "rate_hz"_a = py::none(),
             "first"_a = py::none(), "last"_a = py::none(), "every"_a = py::none(), "pair_tolerance_s"_a = py::none(),
             "bayer"_a = py::none(), "channel"_a = "", "side_by_side"_a = false, "swap_left_right"_a = false,
             "baseline_unit_m"_a = 0.0, "rectified"_a = false, "lens"_a = "", "readout_ms"_a = 0.0,
             "settings"_a = py::none(), "config"_a = py::none());
  module.def("simulate", &simulate, "out"_a, "Render a course with exact truth as a recording; the number of pairs.");
}

}  // namespace cliquevo::python
