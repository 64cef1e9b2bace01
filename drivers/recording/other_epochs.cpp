// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/other_epochs.h"

#include <cmath>

#include "drivers/text_file.h"

namespace cliquevo::drivers {

namespace {

constexpr std::int64_t kWindows1970 = 116'444'736'000'000'000;
constexpr std::int64_t kNet1970 = 621'355'968'000'000'000;
constexpr double kMatlab1970 = 719'529.0;

// The start of 1970 as the clock counts it, where the number is a time of this century.
std::optional<double> start_of_1970(double number, std::int64_t unit_ns) {
  constexpr double kLeast_ns = 0.94e18;  // 2000
  constexpr double kMost_ns = 3e18;      // 2065
  const auto fits = [&](double start) {
    const double ns = (number - start) * static_cast<double>(unit_ns);
    return ns > kLeast_ns && ns < kMost_ns;
  };
  if (unit_ns == kDayNs) return fits(kMatlab1970) ? std::optional(kMatlab1970) : std::nullopt;
  for (const std::int64_t start : {kWindows1970, kNet1970}) {
    if (fits(static_cast<double>(start))) return static_cast<double>(start);
  }
  return std::nullopt;
}

}  // namespace

bool is_of_this_century(double number, std::int64_t unit_ns) { return start_of_1970(number, unit_ns).has_value(); }

std::optional<TimestampNs> since_1970(std::string_view word, std::int64_t unit_ns) {
  if (unit_ns == kDayNs) {
    const auto days = parse_number(word);
    const auto start = days ? start_of_1970(*days, kDayNs) : std::nullopt;
    return start ? std::optional(std::llround((*days - *start) * static_cast<double>(kDayNs))) : std::nullopt;
  }
  const auto ticks = parse_integer(word);
  const auto start = ticks ? start_of_1970(static_cast<double>(*ticks), kTickNs) : std::nullopt;
  return start ? std::optional((*ticks - static_cast<std::int64_t>(*start)) * kTickNs) : std::nullopt;
}

}  // namespace cliquevo::drivers
