// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/pose_stamps.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "drivers/recording/times_file.h"
#include "drivers/text_file.h"

namespace cliquevo::daemon {

namespace {

using drivers::parse_integer;

constexpr std::int64_t kOneSecond = 1'000'000'000;
constexpr double kLeastEpoch = 1e11;  // ms since 1970 are above, seconds below

std::optional<TimestampNs> scaled(double value, std::int64_t unit_ns) {
  const double ns = value * static_cast<double>(unit_ns);
  return std::abs(ns) <= static_cast<double>(drivers::kMostStampNs) ? std::optional(std::llround(ns)) : std::nullopt;
}

// "1403636579763555584.000000" and "1403636579763.5": ns, us and ms since 1970 that were printed as decimals.
std::optional<TimestampNs> decimal_epoch(std::string_view word) {
  const auto value = drivers::parse_number(word);
  if (!value || *value < kLeastEpoch || *value > static_cast<double>(drivers::kMostStampNs)) return std::nullopt;
  const std::size_t point = word.find('.');
  const bool exponent = word.find_first_of("eE") != std::string_view::npos;
  if (exponent || point == std::string_view::npos) return drivers::epoch_stamp(std::llround(*value));
  const auto whole = parse_integer(word.substr(0, point));
  const auto base = whole ? drivers::epoch_stamp(*whole) : std::nullopt;
  const auto next = whole ? drivers::epoch_stamp(*whole + 1) : std::nullopt;
  if (!base || !next) return std::nullopt;
  double part = 0.0;
  if (point + 1 < word.size()) part = drivers::parse_number(word.substr(point)).value_or(0.0);
  return *base + std::llround(part * static_cast<double>(*next - *base));
}

std::optional<TimestampNs> parse_word(std::string_view word, std::int64_t unit_ns) {
  if (word.empty() || word.front() == '+') return std::nullopt;
  const auto whole = parse_integer(word);
  if (unit_ns == 0) {
    if (const auto epoch = whole ? std::nullopt : decimal_epoch(word)) return epoch;
    return drivers::parse_stamp(word);
  }
  TimestampNs out = 0;
  if (whole) return __builtin_mul_overflow(*whole, unit_ns, &out) ? std::nullopt : std::optional(out);
  if (const auto epoch = decimal_epoch(word)) return epoch;
  const auto value = drivers::parse_number(word);
  // Parts of a nanosecond: these are seconds, whatever the heading says.
  if (!value || (unit_ns == 1 && *value != std::floor(*value))) return std::nullopt;
  return scaled(*value, unit_ns);
}

}  // namespace

Result<TimestampNs> stamp_of(const PoseRow& row, const RowReader& reader) {
  const std::string_view word = row.words[*reader.stamp];
  if (reader.nanoseconds) {
    const auto seconds = parse_integer(word);
    const auto part = parse_integer(row.words[*reader.nanoseconds]);
    const bool good = seconds && part && *part >= 0 && *part < kOneSecond;
    if (good && std::abs(static_cast<double>(*seconds)) * 1e9 < static_cast<double>(drivers::kMostStampNs))
      return *seconds * kOneSecond + *part;
    return bad_row(row, fmt::format("'{}' and '{}' are not seconds and nanoseconds", shown(word),
                                    shown(row.words[*reader.nanoseconds])));
  }
  const auto stamp = parse_word(word, reader.unit_ns);
  if (stamp && *stamp >= -drivers::kMostStampNs && *stamp <= drivers::kMostStampNs) return *stamp;
  const std::string unit = reader.unit_ns == 0 ? "seconds" : drivers::unit_name(reader.unit_ns);
  return bad_row(row, fmt::format("'{}' is not a time in {}", shown(word), unit));
}

std::optional<SpacedStamps> stamps_by_spacing(const std::vector<PoseRow>& rows, const RowReader& reader) {
  constexpr double kLeastStep = 1000.0;  // no vehicle's poses come so many seconds apart
  if (reader.unit_ns != 0 || reader.nanoseconds || rows.size() < 2) return std::nullopt;
  std::vector<double> steps;
  std::string text;
  double last = 0.0;
  for (const PoseRow& row : rows) {
    const std::string_view word = *reader.stamp < row.words.size() ? row.words[*reader.stamp] : std::string_view{};
    const auto whole = parse_integer(word);
    if (!whole) return std::nullopt;
    const auto value = static_cast<double>(*whole);
    if (&row != &rows.front()) steps.push_back(value - last);
    last = value;
    text.append(word).push_back('\n');
  }
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  if (*middle < kLeastStep) return std::nullopt;
  const auto table = drivers::parse_times(text, std::string(rows.front().path));
  if (!table || table->rows.size() != rows.size()) return std::nullopt;
  SpacedStamps out;
  out.note = table->note;
  for (const drivers::StampRow& row : table->rows) out.stamps_ns.push_back(row.stamp_ns);
  return out;
}

}  // namespace cliquevo::daemon
