// SPDX-License-Identifier: BSD-3-Clause
// Clocks that count from another year than 1970: ticks of 100 ns from 1601 (Windows) or from year 1 (.NET), and
// MATLAB's days from year 0.
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

#include "core/base/time.h"

namespace cliquevo::drivers {

inline constexpr std::int64_t kTickNs = 100;
inline constexpr std::int64_t kDayNs = 86'400'000'000'000;

// Whether the number is a time from 2000 to 2065 on a clock that counts in this unit (kTickNs or kDayNs).
bool is_of_this_century(double number, std::int64_t unit_ns);
// Such a time, since 1970; none: it is not.
std::optional<TimestampNs> since_1970(std::string_view word, std::int64_t unit_ns);

}  // namespace cliquevo::drivers
