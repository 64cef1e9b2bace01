// SPDX-License-Identifier: BSD-3-Clause
// State of the machine (Linux: /proc and /sys).
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace cliquevo::daemon {

// Bytes of this process's memory that are in RAM; 0 where unknown.
std::int64_t resident_bytes();
// Name and degrees Celsius of each thermal zone that can be read.
std::vector<std::pair<std::string, double>> temperatures();

}  // namespace cliquevo::daemon
