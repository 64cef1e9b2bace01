// SPDX-License-Identifier: BSD-3-Clause
// The names of the logs that the daemon writes: cliquevo-20261128T171500Z-000.lcm, -001 ... for the files of one
// recording, and cliquevo-20261128T171500Z.002-000.lcm ... for a second recording that began at the same time.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cliquevo::daemon {

struct LogName {
  std::int64_t start_s = 0;  // UTC, when the recording began
  int run = 1;               // of the recordings that began then
  int part = 0;              // number of the file within the recording
};

// Nothing: not a name that the daemon gives.
std::optional<LogName> parse_log_name(std::string_view file_name);
// For a recorder, which adds the number of the part.
std::string log_name(std::int64_t start_s, int run);

// What the daemon wrote into the folder, known by name and content, oldest first. Names give the age; a file that was
// last written before the time in its name is as old as that.
std::vector<std::string> own_logs(const std::string& folder);
// The first run of that second that no file in the folder is named after.
int next_run(const std::string& folder, std::int64_t start_s);

}  // namespace cliquevo::daemon
