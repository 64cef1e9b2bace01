// SPDX-License-Identifier: BSD-3-Clause
// Where the stamps of recorded images come from: files of times, or the names of the images.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "core/base/time.h"
#include "drivers/recording/layout.h"

namespace cliquevo::drivers {

// One row of a times file.
struct StampRow {
  TimestampNs stamp_ns = 0;
  std::string name;           // of the image, where the row tells
  bool names_a_file = false;  // with its extension: no mere number
  int line = 0;
};

// A time in any of: decimal seconds ("1687709319.100414", "1.036e-01"), whole ms, us or ns since 1970 (told by their
// magnitude), date and time ("2011-09-26 14:05:37.977365760").
std::optional<TimestampNs> parse_stamp(std::string_view text);

// One row a line: a time; or a time and a name; or a name (or number) and a time, further columns ignored. Error: a bad
// row, stamps that do not rise, naming file and line.
Result<std::vector<StampRow>> parse_times(std::string_view text, const std::string& path);

// Reads the times file into the eye's images, row by row or by name. Error: numbers of rows and images differ.
Result<void> stamps_from_file(const std::string& path, Eye& eye);
// Stamps from the images' names; false (and no change) when the names are no times.
bool stamps_from_names(Eye& eye);

// The times file in a folder (times.txt, timestamps.txt, ...); empty = none.
std::string find_times(const std::string& folder);

}  // namespace cliquevo::drivers
