// SPDX-License-Identifier: BSD-3-Clause
// LCM event logs as files: written so that what is there is whole, read so that what is torn does no harm.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace cliquevo::drivers {

class EventLogWriter {
 public:
  // The file must not be there yet; others than owner and group cannot read it.
  static Result<EventLogWriter> create(const std::string& path);
  EventLogWriter(EventLogWriter&&) noexcept;
  EventLogWriter& operator=(EventLogWriter&&) noexcept;
  ~EventLogWriter();

  // The whole event is with the system when this returns. An error (disk full) closes the file behind its last whole
  // event; later calls fail too.
  Result<void> write(const std::string& channel, const std::uint8_t* data, std::size_t size, std::int64_t utime);
  std::int64_t bytes() const;
  const std::string& path() const;

 private:
  struct Impl;
  explicit EventLogWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// Where an event is.
struct LoggedEvent {
  std::int64_t utime = 0;
  std::int64_t data_at = 0;  // offset in the file
  std::int32_t size = 0;
};

// What is wrong with a log that can be read all the same.
struct LogDamage {
  std::int64_t torn_tail = 0;      // bytes behind the last whole event
  std::int64_t broken_places = 0;  // in the middle: skipped to the next event
};

class EventLogReader {
 public:
  static Result<EventLogReader> open(const std::string& path);
  EventLogReader(EventLogReader&&) noexcept;
  EventLogReader& operator=(EventLogReader&&) noexcept;
  ~EventLogReader();

  // Every event in order of the file; `on_event` gets its channel and place.
  LogDamage scan(const std::function<void(std::string_view, const LoggedEvent&)>& on_event) const;
  // The event's bytes, at most `most` of them.
  Result<void> read(const LoggedEvent& event, std::vector<std::uint8_t>& out, std::size_t most = SIZE_MAX) const;
  const std::string& path() const { return path_; }

 private:
  EventLogReader(int descriptor, std::int64_t size, std::string path);
  bool read_at(std::int64_t at, void* out, std::size_t size) const;

  int descriptor_ = -1;
  std::int64_t size_ = 0;
  std::string path_;
};

// The channel of its first event, if it is an ordinary file (no link) that begins with a whole one; else empty.
std::string first_channel(const std::string& path);
// Whether the file begins as an event log does.
bool looks_like_event_log(const std::string& path);

}  // namespace cliquevo::drivers
