// SPDX-License-Identifier: BSD-3-Clause
// Times in the names of images.
#include <algorithm>
#include <tuple>

#include <fmt/format.h>

#include "drivers/recording/dates.h"
#include "drivers/recording/letters.h"
#include "drivers/recording/stamps.h"
#include "drivers/recording/times_file.h"
#include "drivers/text_file.h"

namespace cliquevo::drivers {

namespace {

// What names begin and end with in common, up to a digit on either side.
std::pair<std::size_t, std::size_t> common_ends(const std::vector<RecordedImage>& images) {
  const std::string& first = images.front().name;
  std::size_t before = first.size();
  std::size_t after = first.size();
  for (const RecordedImage& image : images) {
    const std::string& name = image.name;
    const auto differ = std::mismatch(first.begin(), first.end(), name.begin(), name.end());
    before = std::min(before, static_cast<std::size_t>(differ.first - first.begin()));
    const auto from_end = std::mismatch(first.rbegin(), first.rend(), name.rbegin(), name.rend());
    after = std::min(after, static_cast<std::size_t>(from_end.first - first.rbegin()));
  }
  // Digits, points and dashes belong to the time.
  const auto is_part = [](char c) { return is_digit(c) || c == '.' || c == '-'; };
  while (before > 0 && is_part(first[before - 1])) --before;
  while (after > 0 && is_part(first[first.size() - after])) --after;
  // "1614681437_894528000": where the seconds are the same in all names, they belong to the time as well.
  if (before > 0 && first[before - 1] == '_') {
    std::size_t begin = before - 1;
    while (begin > 0 && is_digit(first[begin - 1])) --begin;
    const std::size_t digits = before - 1 - begin;
    if (digits == 9 || digits == 10) before = begin;
  }
  if (before + after >= first.size()) after = 0;
  return {before, after};
}

constexpr std::int64_t kSecondNs = 1'000'000'000;

// Times that are none since 1970: whole numbers of ten digits and more, in the unit in which they come at a camera's
// rate. Counters stay below.
std::optional<std::int64_t> unit_of_names(const std::vector<std::int64_t>& values) {
  constexpr std::int64_t kLeast = 1'000'000'000;
  constexpr double kLeastStep = 1000.0;
  if (values.size() < 2 || *std::min_element(values.begin(), values.end()) < kLeast) return std::nullopt;
  std::vector<std::int64_t> sorted = values;
  std::sort(sorted.begin(), sorted.end());
  std::vector<double> steps;
  for (std::size_t i = 1; i < sorted.size(); ++i) {
    steps.push_back(static_cast<double>(sorted[i]) - static_cast<double>(sorted[i - 1]));
  }
  std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
  const double step = steps[steps.size() / 2];
  const auto epoch = epoch_stamp(sorted.back());
  const std::int64_t unit_ns = epoch ? *epoch / sorted.back() : kSecondNs;
  const double step_ns = step * static_cast<double>(unit_ns);
  const bool ordinary = step_ns >= 1e6 && step_ns <= 2e9;
  if ((epoch && ordinary) || step < kLeastStep) return std::nullopt;
  const auto unit = unit_by_step(step);
  return unit && sorted.back() <= kMostStampNs / *unit ? unit : std::nullopt;
}

// Of what differs between names: seconds and a part of them as decimal seconds ("1614681437_894528000"); what is behind
// another date ("2018-07-09-16-11-56_2018-07-09-16-12-51-201").
std::string time_part(const std::string& text) {
  const std::size_t at = text.rfind('_');
  if (at == std::string::npos) return text;
  const std::string before = text.substr(0, at);
  std::string after = text.substr(at + 1);
  const bool seconds = before.size() >= 9 && before.size() <= 10 && parse_integer(before);
  if (!seconds || after.size() > 9 || after.empty() || !parse_integer(after)) return after;
  return fmt::format("{}.{}{}", before, after.size() == 6 ? "" : std::string(9 - after.size(), '0'), after);
}

// The middle parts of the names as stamps; empty where they are none.
std::vector<TimestampNs> stamps_of_texts(const std::vector<std::string>& texts, std::vector<std::string>& notes) {
  std::vector<std::int64_t> wholes;
  std::vector<TimestampNs> out;
  for (const std::string& text : texts) {
    if (const auto whole = parse_integer(text)) wholes.push_back(*whole);
  }
  const auto unit = wholes.size() == texts.size() ? unit_of_names(wholes) : std::nullopt;
  for (std::size_t i = 0; i < texts.size(); ++i) {
    std::optional<TimestampNs> stamp = parse_dashed_date(texts[i]);
    if (unit) {
      stamp = wholes[i] * *unit;
    } else if (const auto whole = parse_integer(texts[i]); whole && !stamp) {
      stamp = epoch_stamp(*whole);
    } else if (!stamp && texts[i].find('.') != std::string::npos) {
      stamp = parse_seconds(texts[i]);
    }
    if (!stamp || *stamp < -kMostStampNs || *stamp > kMostStampNs) return {};
    out.push_back(*stamp);
  }
  if (unit) notes.push_back(fmt::format("times in the names taken for {} by their spacing", unit_name(*unit)));
  return out;
}

// "IMG_20180709_161251_201": a date and time in every name, at a camera's rate; empty = they are no such names.
std::vector<TimestampNs> dates_in_names(const std::vector<RecordedImage>& images) {
  constexpr std::int64_t kLeastStep = 2'000'000;  // a counter behind the seconds makes milliseconds
  std::vector<TimestampNs> out;
  for (const RecordedImage& image : images) {
    const auto date = find_compact_date(image.name);
    if (!date) return {};
    out.push_back(*date);
  }
  const std::int64_t step_ns = out.size() > 1 ? period_of(out) : 0;
  return step_ns >= kLeastStep && step_ns <= 2'000'000'000 ? out : std::vector<TimestampNs>{};
}

// Of what differs between the names; empty = it is no time.
std::vector<TimestampNs> times_in_names(const std::vector<RecordedImage>& images, std::vector<std::string>& said) {
  std::size_t before = 0;
  std::size_t after = 0;
  // Alone, a name is a time if it is nothing else.
  if (images.size() > 1) std::tie(before, after) = common_ends(images);
  std::vector<std::string> texts;
  for (const RecordedImage& image : images) {
    if (image.name.size() < before + after) return {};
    std::string text = image.name.substr(before, image.name.size() - before - after);
    text = time_part(text);
    if (text.empty() || text.find_first_not_of("0123456789.-") != std::string::npos || !is_digit(text.front())) {
      return {};
    }
    texts.push_back(std::move(text));
  }
  std::vector<TimestampNs> stamps = stamps_of_texts(texts, said);
  if (stamps.empty()) return {};
  // Numbers with a point beside other words are times only where they come at a camera's rate.
  const bool decimal = texts.front().find('.') != std::string::npos;
  const std::int64_t step_ns = period_of(stamps);
  if (decimal && before + after > 0 && (step_ns < 1'000'000 || step_ns > 2'000'000'000)) return {};
  return stamps;
}

}  // namespace

bool stamps_from_names(ImageList& list, std::vector<std::string>& notes) {
  if (list.images.empty()) return false;
  std::vector<std::string> said;
  std::vector<TimestampNs> stamps = dates_in_names(list.images);
  if (stamps.empty()) stamps = times_in_names(list.images, said);
  if (stamps.empty()) return false;
  std::vector<RecordedImage> images = list.images;
  for (std::size_t i = 0; i < images.size(); ++i) images[i].stamp_ns = stamps[i];
  // The order of names is not that of decimal seconds ("5.2" is behind "5.15").
  std::sort(images.begin(), images.end(),
            [](const RecordedImage& a, const RecordedImage& b) { return a.stamp_ns < b.stamp_ns; });
  for (std::size_t i = 1; i < images.size(); ++i) {
    if (images[i].stamp_ns == images[i - 1].stamp_ns) return false;
  }
  list.images = std::move(images);
  notes.insert(notes.end(), said.begin(), said.end());
  return true;
}

}  // namespace cliquevo::drivers
