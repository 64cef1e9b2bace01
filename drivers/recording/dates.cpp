// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/dates.h"

#include <chrono>

#include "drivers/recording/letters.h"
#include "drivers/text_file.h"

namespace cliquevo::drivers {

namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

// Exactly `digits` digits at the front, taken off.
std::optional<int> take_number(std::string_view& text, std::size_t digits) {
  if (text.size() < digits) return std::nullopt;
  int value = 0;
  for (std::size_t i = 0; i < digits; ++i) {
    if (!is_digit(text[i])) return std::nullopt;
    value = 10 * value + (text[i] - '0');
  }
  text.remove_prefix(digits);
  return value;
}

bool take_char(std::string_view& text, char c) {
  if (text.empty() || text.front() != c) return false;
  text.remove_prefix(1);
  return true;
}

// Seconds since 1970 of a day "2021-03-02", parted by '-', '/' or '.'.
std::optional<std::int64_t> take_day(std::string_view& text) {
  using namespace std::chrono;
  const auto y = take_number(text, 4);
  if (!y || text.empty()) return std::nullopt;
  const char part = text.front();
  if (part != '-' && part != '/' && part != '.') return std::nullopt;
  text.remove_prefix(1);
  const auto m = take_number(text, 2);
  if (!m || !take_char(text, part)) return std::nullopt;
  const auto d = take_number(text, 2);
  if (!d || *y < 1970 || *y > 2100) return std::nullopt;
  const year_month_day day{year{*y}, month{static_cast<unsigned>(*m)}, std::chrono::day{static_cast<unsigned>(*d)}};
  if (!day.ok()) return std::nullopt;
  return sys_days{day}.time_since_epoch().count() * 86400LL;
}

std::int64_t take_fraction_ns(std::string_view& text) {
  std::int64_t ns = 0;
  std::int64_t unit = kSecond / 10;
  while (!text.empty() && is_digit(text.front())) {
    ns += (text.front() - '0') * unit;
    unit /= 10;
    text.remove_prefix(1);
  }
  return ns;
}

// A comma is a decimal one when digits follow, and then the row's end, a blank or an offset.
bool is_decimal_comma(std::string_view text) {
  if (text.size() < 2 || text[0] != ',' || !is_digit(text[1])) return false;
  std::size_t end = 1;
  while (end < text.size() && is_digit(text[end])) ++end;
  return end == text.size() || std::string_view(" \t;\"'Z+-").find(text[end]) != std::string_view::npos;
}

// "10:37:17.000", hours to 23, a leap second allowed.
std::optional<TimestampNs> take_clock(std::string_view& text) {
  const auto h = take_number(text, 2);
  if (!h || !take_char(text, ':')) return std::nullopt;
  const auto m = take_number(text, 2);
  if (!m || !take_char(text, ':')) return std::nullopt;
  const auto s = take_number(text, 2);
  if (!s || *h > 23 || *m > 59 || *s > 60) return std::nullopt;
  TimestampNs ns = (*h * 3600LL + *m * 60LL + *s) * kSecond;
  if (take_char(text, '.') || (is_decimal_comma(text) && take_char(text, ','))) ns += take_fraction_ns(text);
  return ns;
}

// "Z", "+01:00", "+0100", "+01"; seconds east of UTC. None of these: 0.
std::optional<std::int64_t> take_offset_s(std::string_view& text) {
  if (take_char(text, 'Z') || text.empty()) return 0;
  if (text.front() != '+' && text.front() != '-') return 0;
  const std::int64_t sign = text.front() == '-' ? -1 : 1;
  text.remove_prefix(1);
  const auto h = take_number(text, 2);
  if (!h || *h > 18) return std::nullopt;
  const bool colon = take_char(text, ':');
  const auto m = take_number(text, 2);
  if ((colon && !m) || m.value_or(0) > 59) return std::nullopt;
  return sign * (*h * 3600LL + m.value_or(0) * 60LL);
}

// "20210302T103717.123", "20180709_161251_100": date and time without separators of their own.
std::optional<TimestampNs> take_compact(std::string_view& text) {
  using namespace std::chrono;
  std::string_view rest = text;
  const auto y = take_number(rest, 4);
  const auto m = y ? take_number(rest, 2) : std::nullopt;
  const auto d = m ? take_number(rest, 2) : std::nullopt;
  if (!d || *y < 1970 || *y > 2100 || rest.empty() ||
      std::string_view("T_-").find(rest.front()) == std::string_view::npos)
    return std::nullopt;
  const year_month_day day{year{*y}, month{static_cast<unsigned>(*m)}, std::chrono::day{static_cast<unsigned>(*d)}};
  if (!day.ok()) return std::nullopt;
  rest.remove_prefix(1);
  std::int64_t clock_s = 0;
  for (const int most : {23, 59, 60}) {
    const auto value = take_number(rest, 2);
    if (!value || *value > most) return std::nullopt;
    clock_s = 60 * clock_s + *value;
  }
  if (!rest.empty() && is_digit(rest.front())) return std::nullopt;
  TimestampNs ns = 0;
  const bool fraction = rest.size() > 1 && is_digit(rest[1]) && std::string_view("._-").find(rest.front()) < 3;
  if (fraction) {
    rest.remove_prefix(1);
    ns = take_fraction_ns(rest);
  }
  text = rest;
  return (sys_days{day}.time_since_epoch().count() * 86400LL + clock_s) * kSecond + ns;
}

}  // namespace

std::optional<TimestampNs> take_date_time(std::string_view& text) {
  std::string_view rest = text;
  // With the T alone: with other signs it may be a part of an image's name beside its time.
  const bool iso = text.size() > 8 && text[8] == 'T';
  if (const auto compact = iso ? take_compact(rest) : std::nullopt) {
    const auto offset = take_offset_s(rest);
    if (!offset) return std::nullopt;
    text = rest;
    return *compact - *offset * kSecond;
  }
  const auto day_s = take_day(rest);
  if (!day_s || rest.empty()) return std::nullopt;
  if (std::string_view("T _,;\t").find(rest.front()) == std::string_view::npos) return std::nullopt;
  rest.remove_prefix(1);
  while (take_char(rest, ' ')) continue;
  const auto clock_ns = take_clock(rest);
  if (!clock_ns) return std::nullopt;
  const auto offset_s = take_offset_s(rest);
  if (!offset_s) return std::nullopt;
  text = rest;
  return (*day_s - *offset_s) * kSecond + *clock_ns;
}

std::optional<TimestampNs> find_date_time(std::string_view text) {
  for (std::size_t at = 0; at < text.size(); ++at) {
    const bool begins = at == 0 || (!is_digit(text[at - 1]) && !is_letter(text[at - 1]) && text[at - 1] != '-');
    if (!begins || !is_digit(text[at])) continue;
    std::string_view rest = text.substr(at);
    if (const auto date = take_date_time(rest)) return date;
  }
  return std::nullopt;
}

std::optional<TimestampNs> find_compact_date(std::string_view text) {
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (!is_digit(text[at]) || (at > 0 && is_digit(text[at - 1]))) continue;
    std::string_view rest = text.substr(at);
    if (const auto date = take_compact(rest)) return date;
  }
  return std::nullopt;
}

std::optional<TimestampNs> take_time_of_day(std::string_view& text) {
  std::string_view rest = text;
  const auto clock_ns = take_clock(rest);
  if (clock_ns) text = rest;
  return clock_ns;
}

std::optional<TimestampNs> parse_dashed_date(std::string_view text) {
  const auto day_s = take_day(text);
  std::int64_t clock_s = 0;
  for (const int most : {23, 59, 60}) {
    if (!day_s || !take_char(text, '-')) return std::nullopt;
    const auto value = take_number(text, 2);
    if (!value || *value > most) return std::nullopt;
    clock_s = 60 * clock_s + *value;
  }
  std::int64_t ns = 0;
  if (take_char(text, '-')) ns = take_fraction_ns(text);
  if (!text.empty()) return std::nullopt;
  return (*day_s + clock_s) * kSecond + ns;
}

}  // namespace cliquevo::drivers
