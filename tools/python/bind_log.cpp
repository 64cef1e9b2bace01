// SPDX-License-Identifier: BSD-3-Clause
// LCM event logs as Python sequences of events.
#include <map>
#include <pybind11/stl.h>

#include "drivers/recording/event_log.h"
#include "tools/python/arguments.h"
#include "tools/python/bind.h"

namespace cliquevo::python {

namespace {

using namespace py::literals;

struct Event {
  std::int64_t utime_us = 0;
  std::string channel;
  std::vector<std::uint8_t> data;
};

// What is in the log is looked up once; the bytes of an event are read when it is used.
class Log {
 public:
  explicit Log(drivers::EventLogReader reader) : reader_(std::move(reader)) {
    std::map<std::string, std::uint32_t, std::less<>> numbers;
    damage_ = reader_.scan([&](std::string_view channel, const drivers::LoggedEvent& event) {
      auto found = numbers.find(channel);
      if (found == numbers.end()) {
        found = numbers.emplace(std::string(channel), static_cast<std::uint32_t>(channels_.size())).first;
        channels_.emplace_back(channel);
        counts_.push_back(0);
      }
      ++counts_[found->second];
      events_.push_back({event, found->second});
    });
  }

  std::size_t size() const { return events_.size(); }
  Event at(py::ssize_t index) const {
    const auto count = static_cast<py::ssize_t>(events_.size());
    if (index < 0) index += count;
    if (index < 0 || index >= count) throw py::index_error("the log has " + std::to_string(count) + " events");
    const auto& [event, channel] = events_[static_cast<std::size_t>(index)];
    Event out{event.utime, text_for_python(channels_[channel]), {}};
    const auto read = [this, &out, &of = event] {
      const py::gil_scoped_release release;
      return reader_.read(of, out.data);
    }();
    check(read);
    return out;
  }
  std::map<std::string, std::int64_t> channels() const {
    std::map<std::string, std::int64_t> out;
    for (std::size_t i = 0; i < channels_.size(); ++i) out[text_for_python(channels_[i])] += counts_[i];
    return out;
  }
  const drivers::LogDamage& damage() const { return damage_; }

 private:
  struct Place {
    drivers::LoggedEvent event;
    std::uint32_t channel = 0;
  };
  drivers::EventLogReader reader_;
  drivers::LogDamage damage_;
  std::vector<Place> events_;
  std::vector<std::string> channels_;
  std::vector<std::int64_t> counts_;
};

std::unique_ptr<Log> open_log(const py::object& path) {
  const std::string file = path_of(path, "path");
  std::mutex alone;
  return value_of(without_gil(alone, [&]() -> Result<std::unique_ptr<Log>> {
    auto reader = drivers::EventLogReader::open(file);
    if (!reader) return reader.error();
    auto log = std::make_unique<Log>(std::move(*reader));
    if (log->size() == 0) return Error{"no LCM event log", file, "name a log of LCM events, as cliquevo record writes"};
    return log;
  }));
}

}  // namespace

void bind_log(py::module_& module) {
  py::class_<Event>(module, "Event", "One message of a log.")
      .def_readonly("utime_us", &Event::utime_us)
      .def_readonly("channel", &Event::channel)
      .def_property_readonly("data", [](const Event& e) {
        return py::bytes(reinterpret_cast<const char*>(e.data.data()), e.data.size());
      });
  py::class_<Log>(module, "Log", "The messages of an LCM event log, in the file's order.")
      .def(py::init(&open_log), "path"_a)
      .def("__len__", &Log::size)
      .def("__getitem__", &Log::at, "index"_a)
      .def_property_readonly("channels", &Log::channels, "Number of messages on each channel.")
      .def_property_readonly("torn_bytes", [](const Log& log) { return log.damage().torn_tail; })
      .def_property_readonly("broken_places", [](const Log& log) { return log.damage().broken_places; });
}

}  // namespace cliquevo::python
