// SPDX-License-Identifier: BSD-3-Clause
// Dates and times of the day as text.
#pragma once

#include <optional>
#include <string_view>

#include "core/base/time.h"

namespace cliquevo::drivers {

// "2011-09-26 14:05:37.977365760", "2021-03-02T10:37:17,1+01:00", "2021/03/02 09:37:17Z", "20210302T103717.1" at the
// front of `text`, taken off; without an offset it is UTC.
std::optional<TimestampNs> take_date_time(std::string_view& text);
// The first such anywhere in `text`, not inside a word or number.
std::optional<TimestampNs> find_date_time(std::string_view text);
// "20210302T103717.123" or "20180709_161251_201" anywhere in `text`, not behind a digit.
std::optional<TimestampNs> find_compact_date(std::string_view text);
// "14:05:37.977" at the front of `text`, taken off: since midnight.
std::optional<TimestampNs> take_time_of_day(std::string_view& text);
// "2018-07-09-16-12-51-201", the whole of `text`, as some put it into names of images.
std::optional<TimestampNs> parse_dashed_date(std::string_view text);

}  // namespace cliquevo::drivers
