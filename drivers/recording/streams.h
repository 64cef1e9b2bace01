// SPDX-License-Identifier: BSD-3-Clause
// What is in a recording, whether it can be played or not: its streams with their rates and gaps.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/base/time.h"
#include "drivers/recording/recording_options.h"

namespace cliquevo::drivers {

struct RecordedStream {
  std::string name;  // of the topic, channel, folder or file
  std::string type;
  std::int64_t count = 0;
  TimestampNs first_ns = 0;  // as the container has its times; 0 where it has none
  TimestampNs last_ns = 0;
  double rate_hz = 0.0;        // of the median period; 0 = unknown
  std::int64_t gaps = 0;       // of more than one and a half periods
  double longest_gap_s = 0.0;  // 0 where there is no gap
};

struct RecordedStreams {
  std::string kind;  // "MCAP bag", "LCM log", ...
  std::vector<RecordedStream> streams;
  std::string damage;  // what is wrong with what can be read all the same; empty = nothing
};

Result<RecordedStreams> list_streams(const RecordingOptions& options);

}  // namespace cliquevo::drivers
