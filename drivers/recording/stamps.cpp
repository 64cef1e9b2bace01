// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/stamps.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <set>
#include <tuple>

#include <fmt/format.h>

#include "drivers/recording/dates.h"
#include "drivers/recording/times_file.h"
#include "drivers/text_file.h"

namespace cliquevo::drivers {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = 256U << 20U;
// Whose times are not the cameras'; and a camera's own, which count for that camera alone.
constexpr std::array<const char*, 14> kOtherSensors{"imu",   "lidar", "velo",  "laser", "gps",  "gnss",  "ins_",
                                                    "radar", "odom",  "event", "depth", "left", "right", "pose"};

bool is_digit(char c) { return c >= '0' && c <= '9'; }

// How a word of a times file names an image: without folder and extension.
std::string image_named(const std::string& word) {
  const fs::path path(word);
  return is_image_name(word) ? path.stem().string() : path.filename().string();
}

// Which word of the rows names images that are there; none where the rows go by order.
std::optional<std::size_t> naming_word(const std::vector<StampRow>& rows,
                                       const std::map<std::string, std::size_t>& images) {
  constexpr std::size_t kMostWords = 8;
  std::array<std::size_t, kMostWords> hits{};
  std::array<std::size_t, kMostWords> files{};
  for (const StampRow& row : rows) {
    for (std::size_t i = 0; i < std::min(row.words.size(), kMostWords); ++i) {
      if (images.count(image_named(row.words[i])) > 0) ++hits[i];
      if (is_image_name(row.words[i])) ++files[i];
    }
  }
  const auto best = static_cast<std::size_t>(std::max_element(hits.begin(), hits.end()) - hits.begin());
  // A number that counts from elsewhere than the images' names do meets all of them but the first.
  const bool counts = rows.size() == images.size() && hits[best] < images.size();
  if (files[best] > 0 || (2 * hits[best] > images.size() && !counts)) return best;
  const auto file = static_cast<std::size_t>(std::max_element(files.begin(), files.end()) - files.begin());
  return 2 * files[file] > rows.size() ? std::optional(file) : std::nullopt;
}

std::string plural(std::size_t count, const char* one, const char* many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

Result<void> by_name(const TimesTable& table, std::size_t word, const std::map<std::string, std::size_t>& images,
                     const std::string& path, ImageList& list, std::vector<std::string>& notes) {
  std::size_t gone = 0;
  for (const StampRow& row : table.rows) {
    const auto found = word < row.words.size() ? images.find(image_named(row.words[word])) : images.end();
    if (found == images.end()) {
      ++gone;
      continue;
    }
    RecordedImage& image = list.images[found->second];
    if (image.stamp_ns) {
      return Error{"times file names an image twice", fmt::format("{}:{}", path, row.line), "correct the file"};
    }
    image.stamp_ns = row.stamp_ns;
  }
  std::vector<RecordedImage> kept;
  for (RecordedImage& image : list.images) {
    if (image.stamp_ns) kept.push_back(std::move(image));
  }
  if (kept.empty()) {
    const StampRow& first = table.rows.front();
    return Error{
        "times file names no image that is there",
        fmt::format("{}:{} ({})", path, first.line, printable(word < first.words.size() ? first.words[word] : "")),
        "copy the recording again, or correct the file"};
  }
  const std::size_t untold = list.images.size() - kept.size();
  list.images = std::move(kept);
  const std::string name = fs::path(path).filename().string();
  if (gone > 0) notes.push_back(fmt::format("{} of {} without an image", plural(gone, "row", "rows"), name));
  if (untold > 0) notes.push_back(fmt::format("{} not in {}: left out", plural(untold, "image", "images"), name));
  return {};
}

Result<void> by_order(const TimesTable& table, const std::string& path, ImageList& list,
                      std::vector<std::string>& notes) {
  const std::size_t rows = table.rows.size();
  const std::size_t images = list.images.size();
  const bool near = rows == images || rows == images + 1 || (rows + 1 == images && !table.bare_heading);
  if (!near || rows == 0) {
    return Error{
        fmt::format("times file has {} rows for {} images", rows, images), path,
        "copy the recording again, correct the file (one row an image), or give the frame rate with --rate HZ"};
  }
  const std::string name = fs::path(path).filename().string();
  if (rows > images)
    notes.push_back(fmt::format("{} has one row more than there are images: its last is left out", name));
  if (rows < images) {
    notes.push_back(fmt::format("{} has one row fewer than there are images: the last image is left out", name));
    list.images.pop_back();
  }
  for (std::size_t i = 0; i < list.images.size(); ++i) list.images[i].stamp_ns = table.rows[i].stamp_ns;
  return {};
}

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

constexpr double kSecondNs = 1e9;

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
  const double epoch_unit = epoch ? static_cast<double>(*epoch / sorted.back()) : kSecondNs;
  const double step_ns = step * epoch_unit;
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
  const std::string after = text.substr(at + 1);
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

std::int64_t period_of(const std::vector<TimestampNs>& stamps) {
  std::vector<std::int64_t> steps;
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    if (stamps[i] > stamps[i - 1]) steps.push_back(stamps[i] - stamps[i - 1]);
  }
  if (steps.empty()) return 100'000'000;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

}  // namespace

Result<void> stamps_from_file(const std::string& path, ImageList& list, std::vector<std::string>& notes) {
  const Result<std::string> text = read_text_file(path, "times file", kMostBytes);
  if (!text) return text.error();
  const Result<TimesTable> table = parse_times(*text, path);
  if (!table) return table.error();
  std::map<std::string, std::size_t> images;
  for (std::size_t i = 0; i < list.images.size(); ++i) {
    images[list.images[i].name] = i;
    list.images[i].stamp_ns.reset();
  }
  if (!table->note.empty()) notes.push_back(fmt::format("{}: {}", fs::path(path).filename().string(), table->note));
  const auto word = naming_word(table->rows, images);
  return word ? by_name(*table, *word, images, path, list, notes) : by_order(*table, path, list, notes);
}

bool stamps_from_names(ImageList& list, std::vector<std::string>& notes) {
  if (list.images.empty()) return false;
  std::size_t before = 0;
  std::size_t after = 0;
  // A single name is all time.
  if (list.images.size() > 1) std::tie(before, after) = common_ends(list.images);
  std::vector<std::string> texts;
  for (const RecordedImage& image : list.images) {
    if (image.name.size() < before + after) return false;
    std::string text = image.name.substr(before, image.name.size() - before - after);
    text = time_part(text);
    if (text.empty() || text.find_first_not_of("0123456789.-") != std::string::npos || !is_digit(text.front())) {
      return false;
    }
    texts.push_back(std::move(text));
  }
  std::vector<std::string> said;
  const std::vector<TimestampNs> stamps = stamps_of_texts(texts, said);
  if (stamps.empty()) return false;
  // Numbers with a point beside other words are times only where they come at a camera's rate.
  const bool decimal = texts.front().find('.') != std::string::npos;
  const std::int64_t step_ns = period_of(stamps);
  if (decimal && before + after > 0 && (step_ns < 1'000'000 || step_ns > 2'000'000'000)) return false;
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

namespace {

// Times of cameras, by a name that is clear only beside others ("stereo.timestamps", "camera_timestamps.txt").
bool is_times_name(const std::string& name) {
  const auto has = [&](const char* word) { return name.find(word) != std::string::npos; };
  const auto ends = [&](const char* extension) { return name.ends_with(extension); };
  if (!ends(".txt") && !ends(".csv") && !ends(".tsv") && !ends(".timestamps")) return false;
  if (!has("time") && !has("stamp")) return false;
  return std::none_of(kOtherSensors.begin(), kOtherSensors.end(), has);
}

}  // namespace

std::string find_times(const std::string& folder) {
  static constexpr std::array<const char*, 7> kStems{"times",       "timestamps", "timestamp",       "time",
                                                     "time_stamps", "stamps",     "image_timestamps"};
  static constexpr std::array<const char*, 5> kExtensions{".txt", ".csv", ".tsv", ".dat", ""};
  std::error_code ec;
  std::map<std::size_t, std::string> found;  // by preference
  std::vector<std::string> others;
  for (fs::directory_iterator entry(folder, ec); !ec && entry != fs::directory_iterator(); entry.increment(ec)) {
    std::string name = entry->path().filename().string();
    for (char& c : name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    std::error_code ignored;
    if (is_times_name(name) && entry->is_regular_file(ignored)) others.push_back(entry->path().string());
    if (name.front() != 't' && name.front() != 's' && name.front() != 'i') continue;
    for (std::size_t i = 0; i < kStems.size() * kExtensions.size(); ++i) {
      if (name != std::string(kStems[i / kExtensions.size()]) + kExtensions[i % kExtensions.size()]) continue;
      if (entry->is_directory(ignored)) break;
      std::string& place = found[i];
      if (place.empty() || entry->path().string() < place) place = entry->path().string();
    }
  }
  if (!found.empty()) return found.begin()->second;
  return others.size() == 1 ? others.front() : std::string{};
}

std::string find_image_list(const std::string& folder, const ImageList& list) {
  constexpr std::size_t kMostFiles = 50;
  std::error_code ec;
  std::vector<fs::path> files;
  for (fs::directory_iterator entry(folder, ec); !ec && entry != fs::directory_iterator(); entry.increment(ec)) {
    const std::string extension = entry->path().extension().string();
    std::error_code ignored;
    if (extension != ".txt" && extension != ".csv" && extension != ".tsv") continue;
    if (entry->is_regular_file(ignored) && files.size() < kMostFiles) files.push_back(entry->path());
  }
  std::sort(files.begin(), files.end());
  std::set<std::string> names;
  const std::string own = fs::path(list.folder).filename().string();
  for (const RecordedImage& image : list.images) names.insert(image.name);
  const auto is_here = [&](const std::string& word) {
    const fs::path path(word);
    if (!is_image_name(word) || names.count(image_named(word)) == 0) return false;
    return !path.has_parent_path() || path.parent_path().filename().string() == own;
  };
  for (const fs::path& file : files) {
    const Result<std::string> text = read_text_file(file.string(), "times file", kMostBytes);
    const Result<TimesTable> table = text ? parse_times(*text, file.string()) : text.error();
    if (!table) continue;
    const auto named = std::count_if(table->rows.begin(), table->rows.end(), [&](const StampRow& row) {
      return std::any_of(row.words.begin(), row.words.end(), is_here);
    });
    if (2 * static_cast<std::size_t>(named) > list.images.size()) return file.string();
  }
  return {};
}

Result<RisingStamps> make_rising(const std::vector<TimestampNs>& stamps, const std::string& where) {
  RisingStamps out;
  const std::size_t count = stamps.size();
  out.stamps_ns.resize(count);
  out.skipped.resize(count, false);
  out.reason.resize(count);
  const std::int64_t period_ns = period_of(stamps);
  TimestampNs offset_ns = 0;        // by which the clock was set back so far
  std::optional<std::size_t> last;  // that is played
  const auto skip = [&](std::size_t i, std::string why) {
    out.skipped[i] = true;
    out.reason[i] = std::move(why);
    ++out.skipped_count;
  };
  for (std::size_t i = 0; i < count; ++i) {
    if (__builtin_add_overflow(stamps[i], offset_ns, &out.stamps_ns[i]) || out.stamps_ns[i] > kMostStampNs) {
      return Error{"stamps do not rise", where, "they jump by centuries: correct them, or give --rate HZ"};
    }
    if (last && stamps[i] <= stamps[*last]) {
      const double back_s = static_cast<double>(stamps[*last] - stamps[i]) * 1e-9;
      const bool for_good = i + 1 < count && stamps[i + 1] <= stamps[*last] && stamps[i + 1] > stamps[i];
      if (back_s == 0.0) {
        skip(i, "its stamp repeats the one before");
      } else if (!for_good) {
        skip(i, fmt::format("its stamp steps back by {:.6g} s", back_s));
      } else {
        skip(i, fmt::format("the clock steps back by {:.6g} s here; later stamps go on from before", back_s));
        // This pair takes the place of the next regular one, and those behind keep their distance from it.
        out.stamps_ns[i] = out.stamps_ns[*last] + period_ns;
        offset_ns = out.stamps_ns[i] - stamps[i];
        last = i;  // what follows is compared with it
      }
      continue;
    }
    last = i;
  }
  if (2 * out.skipped_count > static_cast<std::int64_t>(count)) {
    return Error{"stamps do not rise", where,
                 fmt::format("{} of {} are not later than the one before: correct them, or give the frame rate with "
                             "--rate HZ",
                             out.skipped_count, count)};
  }
  return out;
}

}  // namespace cliquevo::drivers
