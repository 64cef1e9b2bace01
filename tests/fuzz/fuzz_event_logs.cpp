// SPDX-License-Identifier: BSD-3-Clause
// An LCM event log as a file: scanned, and played as a recording where it is one.
#include <cstdio>
#include <sys/mman.h>
#include <unistd.h>

#include "drivers/recording.h"
#include "drivers/recording/calibration_message.h"
#include "drivers/recording/event_log.h"
#include "drivers/recording/stereo_message.h"
#include "tests/fuzz/expect.h"

namespace {

using namespace cliquevo;

void scan(const std::string& path, std::int64_t size) {
  const auto log = drivers::EventLogReader::open(path);
  fuzz::expect(log.ok(), "an ordinary file opens");
  std::int64_t end = 0;
  std::vector<std::uint8_t> bytes;
  const drivers::LogDamage damage = log->scan([&](std::string_view channel, const drivers::LoggedEvent& event) {
    fuzz::expect(!channel.empty() && event.size >= 0, "an event has a channel and bytes");
    fuzz::expect(event.data_at >= end && event.data_at + event.size <= size, "events lie in the file, in order");
    end = event.data_at + event.size;
    fuzz::expect(log->read(event, bytes).ok(), "an event can be read");
    if (channel == drivers::kCalibrationChannel) {
      const auto info = drivers::parse_calibration_message(bytes.data(), bytes.size(), "log");
      if (!info) fuzz::expect_clear(info.error());
    } else {
      const auto pair = drivers::parse_stereo(bytes.data(), bytes.size(), "log");
      if (!pair) fuzz::expect_clear(pair.error());
    }
  });
  fuzz::expect(damage.torn_tail == size - end && damage.broken_places >= 0, "what is damaged is reported");
}

void play(const std::string& path) {
  drivers::RecordingOptions options;
  options.path = path;
  options.read_ahead = false;
  auto source = drivers::open_recording(options);
  if (!source) return fuzz::expect_clear(source.error());
  drivers::StereoPair pair;
  for (int i = 0; i < 20; ++i) {
    const auto more = (*source)->next(pair);
    if (more.ok() && !*more) return;
    if (!more.ok()) fuzz::expect_clear(more.error());
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const int file = ::memfd_create("log", MFD_CLOEXEC);
  static const std::string path = "/proc/self/fd/" + std::to_string(file);
  fuzz::expect(::ftruncate(file, 0) == 0 && ::pwrite(file, data, size, 0) == static_cast<ssize_t>(size), "a file");
  scan(path, static_cast<std::int64_t>(size));
  play(path);
  return 0;
}
