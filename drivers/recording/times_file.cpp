// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/times_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "drivers/recording/dates.h"
#include "drivers/recording/letters.h"
#include "drivers/recording/other_epochs.h"
#include "drivers/recording/times_rows.h"
#include "drivers/text_file.h"

namespace cliquevo::drivers {

namespace {

constexpr std::int64_t kOneSecond = 1'000'000'000;
constexpr double kLeastRate = 0.5;  // Hz, of any recording worth the name
constexpr double kMostRate = 1000.0;
constexpr double kOrdinaryRate = 20.0;
constexpr std::array<std::int64_t, 4> kUnits{kOneSecond, 1'000'000, 1'000, 1};
constexpr std::size_t kMostColumns = 32;
constexpr std::int64_t kLeastEpoch = 100'000'000'000;  // whole numbers from here on are ms, us or ns since 1970

std::optional<TimestampNs> within_bounds(std::optional<TimestampNs> stamp) {
  return stamp && *stamp >= -kMostStampNs && *stamp <= kMostStampNs ? stamp : std::nullopt;
}

// What the rows hold in one place.
struct Column {
  bool usable = false;  // most rows have a number there
  bool many = false;    // more than one
  bool whole = true;    // whole numbers
  bool rising = false;  // nearly always
  bool counting = false;
  bool still = true;
  std::int64_t most = 0;
  std::int64_t least = 0;
};

std::optional<double> number_at(const TimesRow& row, std::size_t column) {
  return column < row.words.size() ? parse_number(row.words[column]) : std::nullopt;
}

Column column_of(const std::vector<TimesRow>& rows, std::size_t at) {
  Column out;
  std::size_t numbers = 0;
  std::size_t up = 0;
  bool steps_of_one = true;
  std::optional<double> last;
  for (const TimesRow& row : rows) {
    const auto value = number_at(row, at);
    if (!value) continue;
    ++numbers;
    const auto whole = parse_integer(row.words[at]);
    out.whole = out.whole && whole.has_value();
    if (whole) out.most = numbers == 1 ? *whole : std::max(out.most, *whole);
    if (whole) out.least = numbers == 1 ? *whole : std::min(out.least, *whole);
    if (last) {
      up += *value > *last ? 1 : 0;
      steps_of_one = steps_of_one && *value - *last == 1.0;
      out.still = out.still && *value == *last;
    }
    last = value;
  }
  out.usable = 2 * numbers >= rows.size() && numbers > 0;
  out.many = numbers > 1;
  out.rising = numbers > 1 && 4 * up >= 3 * (numbers - 1);
  out.counting = numbers > 1 && steps_of_one && out.whole;
  return out;
}

// The columns that hold the time: one, or seconds and a part of them.
struct TimeColumns {
  std::size_t seconds = 0;
  std::optional<std::size_t> part;
  std::int64_t part_unit_ns = 1;
};

// Seconds beside a part of a second: the part stays below its unit, and the two rise together though neither need rise
// alone. A number that counts beside a time is no such pair, nor is a time beside a flag.
std::optional<TimeColumns> seconds_and_part(const std::vector<Column>& columns) {
  std::optional<TimeColumns> small;
  for (std::size_t i = columns.size(); i-- > 1;) {
    const Column& s = columns[i - 1];
    const Column& p = columns[i];
    if (!s.usable || !p.usable || !s.whole || !p.whole) continue;
    if (s.least < 0 || s.most >= kLeastEpoch || p.least < 0 || p.most >= kOneSecond || (p.still && s.rising)) continue;
    if (s.counting && p.rising && columns.size() > 1) continue;
    TimeColumns found{i - 1, i, 1};
    if (p.most >= 1'000'000) return found;
    if (s.rising || (p.still && s.still)) continue;
    found.part_unit_ns = p.most >= 1000 ? 1'000 : 1'000'000;
    if (!small) small = found;
  }
  return small;
}

// The column named so in the heading, where it has a word for each.
std::optional<std::size_t> named_column(const std::vector<std::string>& heading, const std::vector<Column>& columns) {
  for (const char* wanted : {"timestamp", "stamp", "time", "sec"}) {
    for (std::size_t i = 0; i < heading.size() && i < columns.size(); ++i) {
      if (!columns[i].usable || (!columns[i].rising && columns[i].many)) continue;
      if (lower(heading[i]).find(wanted) != std::string::npos) return i;
    }
  }
  return std::nullopt;
}

std::optional<TimeColumns> find_time(const std::vector<Column>& columns, const std::vector<std::string>& heading) {
  if (const auto pair = seconds_and_part(columns)) return pair;
  if (const auto named = named_column(heading, columns)) return TimeColumns{*named, {}, 1};
  std::vector<std::size_t> choice;
  const auto take = [&](std::size_t from, std::size_t to, bool rising) {
    for (std::size_t i = from; i < std::min(columns.size(), to); ++i) {
      if (columns[i].usable && (columns[i].rising || !rising)) choice.push_back(i);
    }
  };
  take(0, 2, true);
  // Numbers that only count are no times where others rise behind them.
  const bool only_counts =
      std::all_of(choice.begin(), choice.end(), [&](std::size_t i) { return columns[i].counting; });
  if (only_counts) {
    const std::vector<std::size_t> counts = std::exchange(choice, {});
    take(2, kMostColumns, true);
    std::erase_if(choice,
                  [&](std::size_t i) { return !counts.empty() && columns[i].whole && columns[i].most < kLeastEpoch; });
    if (choice.empty()) choice = counts;
  }
  if (choice.empty()) take(0, 2, false);
  const auto keep_if = [&](auto good) {
    std::vector<std::size_t> kept;
    std::copy_if(choice.begin(), choice.end(), std::back_inserter(kept),
                 [&](std::size_t i) { return good(columns[i]); });
    const bool any = !kept.empty();
    if (any) choice = std::move(kept);
    return any;
  };
  if (choice.empty()) return std::nullopt;
  keep_if([](const Column& c) { return !c.counting; });
  const bool plain = keep_if([](const Column& c) { return !c.whole || c.most >= kLeastEpoch; });
  return TimeColumns{plain ? choice.front() : choice.back(), {}, 1};  // a name or number, then the time
}

std::optional<TimestampNs> clock_in(const TimesRow& row) {
  for (const std::string& word : row.words) {
    std::string_view rest = word;
    const auto clock = take_time_of_day(rest);
    if (clock && rest.empty()) return clock;
  }
  return std::nullopt;
}

double median_step(std::vector<double> values) {
  std::vector<double> steps;
  for (std::size_t i = 1; i < values.size(); ++i) steps.push_back(std::abs(values[i] - values[i - 1]));
  if (steps.empty()) return 0.0;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

bool is_ordinary_step(double step_ns) {
  return step_ns >= 1e9 / kMostRate * (1.0 - 1e-9) && step_ns <= 1e9 / kLeastRate * (1.0 + 1e-9);
}

// A unit that the heading names: "timestamp [ns]", "time_us".
std::optional<std::int64_t> unit_in(const std::string& heading) {
  const std::string text = lower(heading);
  const auto has_word = [&](const std::string& word) {
    for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) {
      const bool begins = at == 0 || !is_letter(text[at - 1]);
      const bool ends = at + word.size() >= text.size() || !is_letter(text[at + word.size()]);
      if (begins && ends) return true;
    }
    return false;
  };
  using Names = std::vector<const char*>;
  const std::array<Names, 4> names{Names{"s", "sec", "secs", "second", "seconds"},
                                   Names{"ms", "msec", "millisec", "milliseconds", "millis"},
                                   Names{"us", "usec", "microsec", "microseconds", "micros", "\xC2\xB5s", "\xCE\xBCs"},
                                   Names{"ns", "nsec", "nsecs", "nanosec", "nanoseconds", "nanos"}};
  std::optional<std::int64_t> found;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::none_of(names[i].begin(), names[i].end(), has_word)) continue;
    if (found) return std::nullopt;  // more than one: of other columns
    found = kUnits[i];
  }
  return found;
}

std::optional<TimestampNs> scaled(std::string_view word, std::int64_t unit_ns) {
  if (unit_ns == kOneSecond) return within_bounds(parse_seconds(word));
  if (unit_ns == kTickNs || unit_ns == kDayNs) return within_bounds(since_1970(word, unit_ns));
  if (const auto whole = parse_integer(word)) {
    TimestampNs out = 0;
    if (__builtin_mul_overflow(*whole, unit_ns, &out)) return std::nullopt;
    return within_bounds(out);
  }
  const auto value = parse_number(word);
  const double ns = value ? *value * static_cast<double>(unit_ns) : 1e300;
  if (!(std::abs(ns) <= static_cast<double>(kMostStampNs))) return std::nullopt;
  return std::llround(ns);
}

Error no_time(const std::string& path, int line) {
  return {"times file has a row that is no time", fmt::format("{}:{}", path, line), "put one time in seconds a line"};
}

// The stamps of rows whose time is in one column; `unit` empty: each by its magnitude.
Result<std::vector<TimestampNs>> stamps_in(const std::vector<TimesRow>& rows, std::size_t column,
                                           std::optional<std::int64_t> unit, const std::string& path) {
  std::vector<TimestampNs> out;
  for (const TimesRow& row : rows) {
    if (column >= row.words.size()) return no_time(path, row.line);
    const std::string& word = row.words[column];
    const auto stamp = unit ? scaled(word, *unit) : within_bounds(parse_stamp(word));
    if (!stamp) return no_time(path, row.line);
    out.push_back(*stamp);
  }
  return out;
}

Result<std::vector<TimestampNs>> joined_stamps(const std::vector<TimesRow>& rows, const TimeColumns& time,
                                               const std::string& path) {
  std::vector<TimestampNs> out;
  for (const TimesRow& row : rows) {
    if (*time.part >= row.words.size()) return no_time(path, row.line);
    const auto seconds = scaled(row.words[time.seconds], kOneSecond);
    const auto parts = parse_integer(row.words[*time.part]);
    if (!seconds || !parts || *parts < 0 || *parts >= kOneSecond) return no_time(path, row.line);
    const auto stamp = within_bounds(*seconds + *parts * time.part_unit_ns);
    if (!stamp) return no_time(path, row.line);
    out.push_back(*stamp);
  }
  return out;
}

// Of whole numbers by their magnitude; 0 = they are of several.
std::int64_t obvious_unit(const std::vector<TimesRow>& rows, std::size_t column) {
  std::int64_t unit = -1;
  for (const TimesRow& row : rows) {
    std::int64_t here = kOneSecond;
    const auto whole = column < row.words.size() ? parse_integer(row.words[column]) : std::nullopt;
    if (whole && *whole >= kLeastEpoch)
      here = *whole >= 100'000'000'000'000'000 ? 1 : *whole >= 100'000'000'000'000 ? 1'000 : 1'000'000;
    if (unit >= 0 && here != unit) return 0;
    unit = here;
  }
  return unit;
}

// The unit other than the obvious one in which the numbers are likelier; none: they are as they seem.
std::optional<std::int64_t> likelier_unit(const std::vector<TimesRow>& rows, std::size_t column,
                                          const std::string& heading) {
  std::vector<double> values;
  values.reserve(rows.size());
  for (const TimesRow& row : rows) values.push_back(number_at(row, column).value_or(0.0));
  if (values.size() < 2) return std::nullopt;
  const double most = std::abs(*std::max_element(values.begin(), values.end()));
  const double step = median_step(std::move(values));
  const auto fits = [&](std::int64_t unit) {
    const auto ns = static_cast<double>(unit);
    return is_ordinary_step(step * ns) && most * ns <= static_cast<double>(kMostStampNs);
  };
  const std::int64_t obvious = obvious_unit(rows, column);
  if (obvious == 0) return std::nullopt;
  if (const auto named = unit_in(heading); named && *named != obvious && fits(*named)) return named;
  // Ticks of today would be ns of the seventies.
  for (const std::int64_t unit : {kTickNs, kDayNs}) {
    if (is_of_this_century(most, unit) && is_ordinary_step(step * static_cast<double>(unit))) return unit;
  }
  if (fits(obvious)) return std::nullopt;
  const auto other = unit_by_step(step);
  return other && fits(*other) ? other : std::nullopt;
}

// Dates, or times of the day, in every row; none where the first row has neither.
std::optional<Result<std::vector<TimestampNs>>> dated_stamps(const std::vector<TimesRow>& rows,
                                                             const std::string& path) {
  const bool dates = find_date_time(rows.front().text).has_value();
  if (!dates && !clock_in(rows.front())) return std::nullopt;
  std::vector<TimestampNs> out;
  for (const TimesRow& row : rows) {
    const auto stamp = dates ? find_date_time(row.text) : clock_in(row);
    if (!stamp) return Result<std::vector<TimestampNs>>(no_time(path, row.line));
    out.push_back(*stamp);
  }
  return Result<std::vector<TimestampNs>>(std::move(out));
}

}  // namespace

std::optional<TimestampNs> epoch_stamp(std::int64_t value) {
  // From 1973 to 2115 they do not overlap.
  if (value >= 100'000'000'000'000'000) return within_bounds(value);
  if (value >= 100'000'000'000'000) return value <= kMostStampNs / 1000 ? std::optional(value * 1000) : std::nullopt;
  if (value >= 100'000'000'000 && value <= kMostStampNs / 1'000'000) return value * 1'000'000;
  return std::nullopt;
}

std::optional<TimestampNs> parse_stamp(std::string_view text) {
  std::string_view rest = text;
  if (const auto date = take_date_time(rest); date && rest.empty()) return date;
  if (const std::optional<std::int64_t> whole = parse_integer(text)) {
    if (const std::optional<TimestampNs> epoch = epoch_stamp(*whole)) return epoch;
  }
  return parse_seconds(text);
}

std::optional<std::int64_t> unit_by_step(double step) {
  std::optional<std::int64_t> best;
  double best_distance = std::numeric_limits<double>::infinity();
  for (const std::int64_t unit : kUnits) {
    const double step_ns = step * static_cast<double>(unit);
    if (!is_ordinary_step(step_ns)) continue;
    const double distance = std::abs(std::log(1e9 / step_ns / kOrdinaryRate));
    if (distance >= best_distance) continue;
    best = unit;
    best_distance = distance;
  }
  return best;
}

std::string unit_name(std::int64_t unit_ns) {
  for (const auto& [unit, name] :
       {std::pair{kOneSecond, "s"}, std::pair{kDayNs, "days"}, std::pair{kTickNs, "ticks of 100 ns"},
        std::pair{std::int64_t{1'000'000}, "ms"}, std::pair{std::int64_t{1'000}, "us"}}) {
    if (unit == unit_ns) return name;
  }
  return "ns";
}

Result<TimesTable> parse_times(std::string_view text, const std::string& path) {
  const TimesText split = split_times(text);
  if (split.rows.empty()) return Error{"times file is empty", path, "put one time in seconds a line"};
  const auto finish = [&](const std::vector<TimestampNs>& stamps, std::string note) {
    TimesTable out;
    out.bare_heading = split.bare_heading;
    out.note = std::move(note);
    for (std::size_t i = 0; i < stamps.size(); ++i) {
      out.rows.push_back({stamps[i], split.rows[i].words, split.rows[i].line});
    }
    return out;
  };
  if (auto dated = dated_stamps(split.rows, path)) {
    if (!*dated) return dated->error();
    return finish(**dated, {});
  }
  std::vector<Column> columns;
  std::size_t widest = 0;
  for (const TimesRow& row : split.rows) widest = std::max(widest, row.words.size());
  for (std::size_t i = 0; i < std::min(widest, kMostColumns); ++i) columns.push_back(column_of(split.rows, i));
  const auto time = find_time(columns, split.heading_words);
  if (!time) return no_time(path, split.rows.front().line);
  if (time->part) {
    const auto stamps = joined_stamps(split.rows, *time, path);
    if (!stamps) return stamps.error();
    return finish(*stamps, {});
  }
  const auto unit = likelier_unit(split.rows, time->seconds, split.heading);
  const auto stamps = stamps_in(split.rows, time->seconds, unit, path);
  if (!stamps) return stamps.error();
  return finish(*stamps, unit ? fmt::format("times taken for {} by their spacing", unit_name(*unit)) : std::string{});
}

}  // namespace cliquevo::drivers
