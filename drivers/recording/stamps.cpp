// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/stamps.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <set>

#include <fmt/format.h>

#include "drivers/recording/times_file.h"
#include "drivers/text_file.h"

namespace cliquevo::drivers {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = 256U << 20U;
// Whose times are not the cameras'; and a camera's own, which count for that camera alone.
constexpr std::array<const char*, 14> kOtherSensors{"imu",   "lidar", "velo",  "laser", "gps",  "gnss",  "ins_",
                                                    "radar", "odom",  "event", "depth", "left", "right", "pose"};

// How a word of a times file names an image: without folder and extension.
std::string image_named(const std::string& word) {
  const fs::path path(word);
  return is_image_name(word) ? path.stem().string() : path.filename().string();
}

// Which word of the rows names images that are there, of so many; none where the rows go by order.
std::optional<std::size_t> naming_word(const std::vector<StampRow>& rows,
                                       const std::map<std::string, std::size_t>& images, std::size_t count) {
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
  const bool counts = rows.size() == count && hits[best] < count;
  if (files[best] > 0 || (2 * hits[best] > count && !counts)) return best;
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

}  // namespace

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
  // Names without the word for their side may stand with it in the file.
  for (std::size_t i = 0; i < list.images.size(); ++i) images.emplace(fs::path(list.images[i].path).stem().string(), i);
  if (!table->note.empty()) notes.push_back(fmt::format("{}: {}", fs::path(path).filename().string(), table->note));
  const auto word = naming_word(table->rows, images, list.images.size());
  return word ? by_name(*table, *word, images, path, list, notes) : by_order(*table, path, list, notes);
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
  static constexpr std::array<const char*, 8> kStems{"times",       "timestamps", "timestamp",        "time",
                                                     "time_stamps", "stamps",     "image_timestamps", "frames"};
  static constexpr std::array<const char*, 5> kExtensions{".txt", ".csv", ".tsv", ".dat", ""};
  std::error_code ec;
  std::map<std::size_t, std::string> found;  // by preference
  std::vector<std::string> others;
  for (fs::directory_iterator entry(folder, ec); !ec && entry != fs::directory_iterator(); entry.increment(ec)) {
    std::string name = entry->path().filename().string();
    for (char& c : name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    std::error_code ignored;
    if (is_times_name(name) && entry->is_regular_file(ignored)) others.push_back(entry->path().string());
    if (std::string_view("tsif").find(name.front()) == std::string_view::npos) continue;
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
  for (const RecordedImage& image : list.images) {
    names.insert(image.name);
    names.insert(fs::path(image.path).stem().string());
  }
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
