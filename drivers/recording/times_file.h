// SPDX-License-Identifier: BSD-3-Clause
// Files of times, as all kinds of programs write them: which column holds the time, and in which unit.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/base/time.h"

namespace cliquevo::drivers {

// One row of a times file.
struct StampRow {
  TimestampNs stamp_ns = 0;
  std::vector<std::string> words;  // as they stand in the row: one may name the image
  int line = 0;
};

struct TimesTable {
  std::vector<StampRow> rows;  // at least one; stamps as they are, rising or not
  std::string note;            // what was concluded rather than read; empty = nothing
  bool bare_heading = false;   // the first line was taken for a heading though it has no '#'
};

// Columns are parted by blanks, tabs, commas or semicolons, words may be quoted. A time is a date and time (with an
// offset from UTC or without), a time of the day, decimal seconds (with a point or a comma), a whole number of ms, us
// or ns, or seconds and nanoseconds in two columns; a heading is left out. Whole numbers that are no times since 1970
// take the unit in which they come at 0.5 to 1000 Hz; so do ticks of Windows and .NET, and MATLAB's days. Error: a row
// that is no time, naming file and line.
Result<TimesTable> parse_times(std::string_view text, const std::string& path);

// One time on its own: decimal seconds ("1687709319.100414", "1.036e-01"), whole ms, us or ns since 1970 (by their
// magnitude), date and time ("2011-09-26 14:05:37.977365760", "2021-03-02T10:37:17.1+01:00").
std::optional<TimestampNs> parse_stamp(std::string_view text);
// Whole numbers that can only be ms, us or ns since 1970.
std::optional<TimestampNs> epoch_stamp(std::int64_t value);

// The unit [ns] in which numbers with this median step come at 0.5 to 1000 Hz: the one nearest to an ordinary camera's
// rate. None: there is no such unit.
std::optional<std::int64_t> unit_by_step(double median_step);
std::string unit_name(std::int64_t unit_ns);

// Stamps that everything behind can subtract from one another without overflow.
inline constexpr TimestampNs kMostStampNs = 4'600'000'000'000'000'000;

}  // namespace cliquevo::drivers
