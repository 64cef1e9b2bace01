// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/stamps.h"

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "drivers/text_file.h"

namespace cliquevo::drivers {

namespace {

constexpr std::size_t kMostBytes = 256U << 20U;

// Whole numbers that can only be ms, us or ns since 1970: from 1973 to 2262, where int64 ns end, they do not overlap.
std::optional<TimestampNs> epoch_stamp(std::int64_t value) {
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  if (value >= 100'000'000'000'000'000) return value;
  if (value >= 100'000'000'000'000 && value <= kMost / 1000) return value * 1000;
  if (value >= 100'000'000'000 && value <= kMost / 1'000'000) return value * 1'000'000;
  return std::nullopt;
}

std::optional<TimestampNs> parse_date(std::string_view date, std::string_view time) {
  const auto number = [](std::string_view s) -> int {
    const std::optional<std::int64_t> v =
        s.empty() || s.front() < '0' || s.front() > '9' ? std::nullopt : parse_integer(s);
    return v && *v < 100000 ? static_cast<int>(*v) : -1;
  };
  if (date.size() != 10 || date[4] != '-' || date[7] != '-') return std::nullopt;
  if (time.size() < 8 || time[2] != ':' || time[5] != ':') return std::nullopt;
  using namespace std::chrono;
  const int y = number(date.substr(0, 4));
  const int mo = number(date.substr(5, 2));
  const int d = number(date.substr(8, 2));
  const int h = number(time.substr(0, 2));
  const int mi = number(time.substr(3, 2));
  const TimestampNs s = parse_seconds(time.substr(6)).value_or(-1);
  if (y < 1970 || y > 2200 || mo < 1 || d < 1 || h < 0 || h > 23 || mi < 0 || mi > 59) return std::nullopt;
  if (s < 0 || s >= 61'000'000'000) return std::nullopt;
  const year_month_day day{year{y}, month{static_cast<unsigned>(mo)}, std::chrono::day{static_cast<unsigned>(d)}};
  if (!day.ok()) return std::nullopt;
  const std::int64_t seconds = sys_days{day}.time_since_epoch().count() * 86400LL + h * 3600LL + mi * 60LL;
  return seconds * 1'000'000'000LL + s;
}

std::string stem_of(std::string_view file) { return std::filesystem::path(std::string(file)).stem().string(); }

std::optional<StampRow> parse_row(std::string_view line) {
  const std::vector<std::string_view> words = split_words(line);
  StampRow row;
  if (words.empty()) return std::nullopt;
  if (words.size() >= 2) {
    if (const std::optional<TimestampNs> date = parse_date(words[0], words[1])) {
      row.stamp_ns = *date;
      return row;
    }
  }
  const std::optional<TimestampNs> first = parse_stamp(words[0]);
  if (words.size() == 1) {
    if (!first) return std::nullopt;
    row.stamp_ns = *first;
    return row;
  }
  const std::optional<TimestampNs> second = parse_stamp(words[1]);
  if (second) {  // name or number, time
    row.stamp_ns = *second;
    row.name = stem_of(words[0]);
    row.names_a_file = is_image_name(std::string(words[0]));
    return row;
  }
  if (!first) return std::nullopt;
  row.stamp_ns = *first;
  row.name = stem_of(words[1]);
  row.names_a_file = is_image_name(std::string(words[1]));
  return row;
}

}  // namespace

std::optional<TimestampNs> parse_stamp(std::string_view text) {
  if (text.size() > 11 && (text[10] == 'T' || text[10] == ' ')) {
    if (const auto date = parse_date(text.substr(0, 10), text.substr(11))) return date;
  }
  if (const std::optional<std::int64_t> whole = parse_integer(text)) {
    if (const std::optional<TimestampNs> epoch = epoch_stamp(*whole)) return epoch;
  }
  return parse_seconds(text);
}

Result<std::vector<StampRow>> parse_times(std::string_view text, const std::string& path) {
  std::vector<StampRow> rows;
  for (const TextLine& line : split_lines(text)) {
    const std::string where = fmt::format("{}:{}", path, line.number);
    std::optional<StampRow> row = parse_row(line.text);
    if (!row) return Error{"times file has a row that is no time", where, "put one time in seconds a line"};
    if (!rows.empty() && row->stamp_ns <= rows.back().stamp_ns) {
      return Error{"stamps do not rise", where, "each image must be later than the one before: correct the file"};
    }
    row->line = line.number;
    rows.push_back(std::move(*row));
  }
  if (rows.empty()) return Error{"times file is empty", path, "put one time in seconds a line"};
  return rows;
}

Result<void> stamps_from_file(const std::string& path, Eye& eye) {
  const Result<std::string> text = read_text_file(path, "times file", kMostBytes);
  if (!text) return text.error();
  const Result<std::vector<StampRow>> rows = parse_times(*text, path);
  if (!rows) return rows.error();
  if (rows->size() != eye.images.size()) {
    return Error{fmt::format("times file has {} rows for {} images", rows->size(), eye.images.size()), path,
                 "copy the recording again, or correct the file: one row an image"};
  }
  // Rows that name their image go by name (all of them, or none).
  std::map<std::string, std::size_t> by_name;
  for (std::size_t i = 0; i < eye.images.size(); ++i) {
    by_name[eye.images[i].name] = i;
    eye.images[i].stamp_ns.reset();
  }
  const bool named = std::all_of(rows->begin(), rows->end(), [&](const StampRow& row) {
    return row.names_a_file || (!row.name.empty() && by_name.count(row.name) > 0);
  });
  for (std::size_t i = 0; i < rows->size(); ++i) {
    const StampRow& row = rows.value()[i];
    if (named && by_name.count(row.name) == 0) {
      return Error{"times file names an image that is not there",
                   fmt::format("{}:{} ({})", path, row.line, printable(row.name)),
                   "copy the recording again, or correct the file"};
    }
    EyeImage& image = eye.images[named ? by_name[row.name] : i];
    if (image.stamp_ns) {
      return Error{"times file names an image twice", fmt::format("{}:{}", path, row.line), "correct the file"};
    }
    image.stamp_ns = row.stamp_ns;
  }
  return {};
}

bool stamps_from_names(Eye& eye) {
  std::vector<EyeImage> images = eye.images;
  for (EyeImage& image : images) {
    image.stamp_ns.reset();
    if (image.name.find_first_not_of("0123456789.") != std::string::npos) return false;
    if (const std::optional<std::int64_t> whole = parse_integer(image.name)) {
      image.stamp_ns = epoch_stamp(*whole);
    } else if (image.name.find('.') != std::string::npos) {
      image.stamp_ns = parse_seconds(image.name);
    }
    if (!image.stamp_ns) return false;
  }
  // The order of names is not that of decimal seconds ("5.2" is behind "5.15").
  std::sort(images.begin(), images.end(), [](const EyeImage& a, const EyeImage& b) { return a.stamp_ns < b.stamp_ns; });
  for (std::size_t i = 1; i < images.size(); ++i) {
    if (images[i].stamp_ns == images[i - 1].stamp_ns) return false;
  }
  eye.images = std::move(images);
  return true;
}

std::string find_times(const std::string& folder) {
  std::error_code ec;
  for (const char* name : {"times.txt", "timestamps.txt", "timestamp.txt", "times.csv", "timestamps.csv"}) {
    const std::filesystem::path file = std::filesystem::path(folder) / name;
    if (std::filesystem::exists(file, ec)) return file.string();
  }
  return {};
}

}  // namespace cliquevo::drivers
