// SPDX-License-Identifier: BSD-3-Clause
// LCM event logs as recordings.
#include <algorithm>
#include <filesystem>
#include <map>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "drivers/calibration/checks.h"
#include "drivers/images/image_reader.h"
#include "drivers/images/masks.h"
#include "drivers/recording/calibration_message.h"
#include "drivers/recording/event_log.h"
#include "drivers/recording/pair_store.h"
#include "drivers/recording/pairing.h"
#include "drivers/recording/stereo_message.h"
#include "drivers/recording/times_file.h"

namespace cliquevo::drivers {

namespace fs = std::filesystem;

namespace {

// A pair in one of the logs.
struct LoggedPair {
  std::size_t file = 0;
  LoggedEvent event;
  TimestampNs stamp_ns = 0;
  int calibration = -1;  // the one in force, -1 = none came before
};

struct Contents {
  std::vector<EventLogReader> files;
  std::vector<LoggedPair> pairs;
  std::vector<SourceInfo> calibrations;  // in order, each unlike the one before
  LogDamage damage;
};

// The images of a message, decoded where they are compressed.
class MessageReader {
 public:
  Result<void> read(const EventLogReader& file, const LoggedEvent& event, const std::string& name, StereoPair& pair) {
    if (auto ok = file.read(event, bytes_); !ok) return ok;
    const auto message = parse_stereo(bytes_.data(), bytes_.size(), name);
    if (!message) return message.error();
    if (auto ok = take(message->left, name + ", left", pair.left); !ok) return ok;
    if (auto ok = take(message->right, name + ", right", pair.right); !ok) return ok;
    pair.right_offset_ns = message->right.stamp_ns - message->left.stamp_ns;
    pair.host_ns = message->left.host_ns;
    return {};
  }
  std::int64_t warned() const { return images_.warned(); }

 private:
  Result<void> take(const StereoMessageSide& side, const std::string& name, Image<std::uint8_t>& image) {
    if (side.jpeg != nullptr) return images_.decode(side.jpeg, side.jpeg_size, name, image);
    image.copy_from(side.image);
    return {};
  }

  ImageReader images_;
  std::vector<std::uint8_t> bytes_;
};

class LoggedPairs final : public PairStore {
 public:
  LoggedPairs(std::vector<EventLogReader> files, std::vector<LoggedPair> pairs, std::vector<std::int64_t> numbers,
              int width, int height)
      : files_(std::move(files)),
        pairs_(std::move(pairs)),
        numbers_(std::move(numbers)),
        width_(width),
        height_(height) {}

  std::int64_t size() const override { return static_cast<std::int64_t>(pairs_.size()); }
  std::string name(std::int64_t i) const override {
    const auto at = static_cast<std::size_t>(i);
    return fmt::format("{}, pair {}", files_[pairs_[at].file].path(), numbers_[at]);
  }
  Result<void> load(std::int64_t i, StereoPair& pair) override {
    const LoggedPair& at = pairs_[static_cast<std::size_t>(i)];
    if (auto ok = reader_.read(files_[at.file], at.event, name(i), pair); !ok) return ok;
    for (const Image<std::uint8_t>* image : {&pair.left, &pair.right}) {
      if (image->cview().same_size(width_, height_)) continue;
      return Error{"image has another size than the recording", name(i),
                   fmt::format("it is {}x{}, the others are {}x{}: choose pairs of one size", image->width(),
                               image->height(), width_, height_)};
    }
    return {};
  }
  std::int64_t warned() const override { return reader_.warned(); }

 private:
  std::vector<EventLogReader> files_;
  std::vector<LoggedPair> pairs_;
  std::vector<std::int64_t> numbers_;  // among all pairs of the log
  int width_;
  int height_;
  MessageReader reader_;
};

// What makes two calibrations the same, whenever and under whatever name they were written.
std::vector<std::uint8_t> content_of(SourceInfo& info) {
  const std::string description = std::exchange(info.description, {});
  const std::string source = std::exchange(info.calibration.source, {});
  const double rate_hz = std::exchange(info.rate_hz, 0.0);
  std::vector<std::uint8_t> out = encode_calibration(info, 0);
  info.description = description;
  info.calibration.source = source;
  info.rate_hz = rate_hz;
  return out;
}

// Sorts a log's events into calibrations and stereo pairs by channel.
class Collector {
 public:
  void add(const EventLogReader& file, std::size_t number, std::string_view channel, const LoggedEvent& event,
           Contents& contents) {
    if (channel == kCalibrationChannel) {
      add_calibration(file, event, contents);
      return;
    }
    if (!is_stereo(file, channel, event)) return;
    pairs_[std::string(channel)].push_back({number, event, 0, static_cast<int>(contents.calibrations.size()) - 1});
  }

  // Of the channel that was chosen, else of the only one there is.
  Result<std::vector<LoggedPair>> pairs(const RecordingOptions& options) {
    if (pairs_.empty()) {
      return Error{"no stereo pair in the log", options.path, "name a log with images_t messages (VO_STEREO)"};
    }
    std::string names;
    for (const auto& [channel, of_it] : pairs_) {
      names += fmt::format("{}{} ({} pairs)", names.empty() ? "" : ", ", channel, of_it.size());
    }
    if (options.channel.empty() && pairs_.size() > 1) {
      return Error{"log holds several stereo channels", options.path, "choose one with --channel NAME: " + names};
    }
    const auto wanted = options.channel.empty() ? pairs_.begin() : pairs_.find(options.channel);
    if (wanted != pairs_.end()) return std::move(wanted->second);
    return Error{"log has no stereo pairs on this channel", fmt::format("{} ({})", options.path, options.channel),
                 "choose one of " + names};
  }

  std::optional<Error> calibration_error;

 private:
  static constexpr int kTries = 8;  // messages of a channel that are looked at before it is given up

  void add_calibration(const EventLogReader& file, const LoggedEvent& event, Contents& contents) {
    if (!file.read(event, bytes_)) return;
    auto info = parse_calibration_message(bytes_.data(), bytes_.size(), file.path());
    if (!info) {
      if (!calibration_error) calibration_error = info.error();
      return;
    }
    std::vector<std::uint8_t> content = content_of(*info);
    if (!contents.calibrations.empty() && content == last_calibration_) return;
    contents.calibrations.push_back(std::move(*info));
    last_calibration_ = std::move(content);
  }
  bool is_stereo(const EventLogReader& file, std::string_view channel, const LoggedEvent& event) {
    auto known = tries_left_.find(channel);
    if (known == tries_left_.end()) known = tries_left_.emplace(std::string(channel), kTries).first;
    if (known->second < 0) return true;
    if (known->second == 0) return false;
    const bool stereo = file.read(event, bytes_, 256).ok() && is_stereo_message(bytes_.data(), bytes_.size());
    known->second = stereo ? -1 : known->second - 1;
    return stereo;
  }

  std::map<std::string, int, std::less<>> tries_left_;  // by channel; -1 = it carries stereo pairs
  std::map<std::string, std::vector<LoggedPair>> pairs_;
  std::vector<std::uint8_t> last_calibration_;
  std::vector<std::uint8_t> bytes_;
};

// A damaged log may hold any number: the difference of two stamps still is one.
TimestampNs from_us(std::int64_t us) {
  constexpr std::int64_t kMostUs = kMostStampNs / 1000;
  return std::clamp(us, -kMostUs, kMostUs) * 1000;
}

// Exposures, without reading the pixels. A message that cannot be read keeps the log's time, and is next()'s to report.
void read_stamps(Contents& contents) {
  constexpr std::size_t kEnough = 128;
  std::vector<std::uint8_t> bytes;
  for (LoggedPair& pair : contents.pairs) {
    const EventLogReader& file = contents.files[pair.file];
    pair.stamp_ns = from_us(pair.event.utime);
    if (!file.read(pair.event, bytes, kEnough)) continue;
    const StereoMessageStart start = parse_stereo_start(bytes.data(), bytes.size());
    if (start.utime) pair.stamp_ns = from_us(*start.utime);
    if (start.metadata_at <= 0 || start.metadata_at >= pair.event.size) continue;
    LoggedEvent metadata = pair.event;
    metadata.data_at += start.metadata_at;
    metadata.size -= static_cast<std::int32_t>(start.metadata_at);
    if (!file.read(metadata, bytes, kEnough)) continue;
    const TimestampNs stamp_ns = parse_stereo_stamp(bytes.data(), bytes.size()).value_or(pair.stamp_ns);
    pair.stamp_ns = std::clamp(stamp_ns, -kMostStampNs, kMostStampNs);
  }
}

Result<Contents> read_logs(const std::vector<std::string>& paths, const RecordingOptions& options) {
  Contents contents;
  std::vector<std::pair<std::int64_t, EventLogReader>> files;  // by the time of their first event
  for (const std::string& path : paths) {
    auto file = EventLogReader::open(path);
    if (!file) return file.error();
    std::int64_t first = INT64_MAX;
    const LogDamage damage =
        file->scan([&](std::string_view, const LoggedEvent& event) { first = std::min(first, event.utime); });
    contents.damage.torn_tail += damage.torn_tail;
    contents.damage.broken_places += damage.broken_places;
    files.emplace_back(first, std::move(*file));
  }
  std::stable_sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (auto& [first, file] : files) contents.files.push_back(std::move(file));
  Collector collector;
  for (std::size_t i = 0; i < contents.files.size(); ++i) {
    const EventLogReader& file = contents.files[i];
    file.scan(
        [&](std::string_view channel, const LoggedEvent& event) { collector.add(file, i, channel, event, contents); });
  }
  auto pairs = collector.pairs(options);
  if (!pairs) return pairs.error();
  contents.pairs = std::move(*pairs);
  if (contents.calibrations.empty() && options.calibration.empty()) {
    if (collector.calibration_error) return *collector.calibration_error;
    return missing_calibration(options.path);
  }
  return contents;
}

Result<std::pair<int, int>> size_of_first(const Contents& contents) {
  MessageReader reader;
  StereoPair pair;
  std::optional<Error> error;
  for (const LoggedPair& at : contents.pairs) {
    const EventLogReader& file = contents.files[at.file];
    auto read = reader.read(file, at.event, file.path(), pair);
    if (read) return std::pair{pair.left.width(), pair.left.height()};
    if (!error) error = read.error();
  }
  return *error;
}

// Only what one calibration holds for is played at once.
Result<int> calibration_of(const Contents& contents, const std::vector<std::int64_t>& numbers,
                           const RecordingOptions& options) {
  const auto in_force = [&](std::size_t i) { return std::max(0, contents.pairs[i].calibration); };
  for (std::size_t i = 1; i < contents.pairs.size(); ++i) {
    if (in_force(i) == in_force(0)) continue;
    return Error{
        "log has another calibration later on", fmt::format("{}, pair {}", options.path, numbers[i]),
        fmt::format("play it in parts: --last {}, then --first {}; or name one for all with --calibration FILE",
                    numbers[i] - 1, numbers[i])};
  }
  return in_force(0);
}

std::string describe_log(const RecordingOptions& options, std::size_t files, const LogDamage& damage) {
  std::string out = fmt::format("LCM log {}", options.path);
  if (!options.channel.empty()) out += fmt::format(" (channel {})", options.channel);
  if (files > 1) out += fmt::format(" ({} files)", files);
  if (damage.torn_tail > 0) {
    out += fmt::format(" (cut off: {} bytes behind its last whole event)", damage.torn_tail);
  }
  if (damage.broken_places > 0) {
    out += fmt::format(" (damaged in {} places: events left out)", damage.broken_places);
  }
  return out;
}

}  // namespace

std::vector<std::string> find_logs(const std::string& path) {
  std::error_code ec;
  if (fs::is_regular_file(path, ec)) {
    return looks_like_event_log(path) ? std::vector<std::string>{path} : std::vector<std::string>{};
  }
  std::vector<std::string> logs;
  for (fs::directory_iterator entry(path, ec); !ec && entry != fs::directory_iterator(); entry.increment(ec)) {
    const std::string file = entry->path().string();
    if (entry->path().extension() == ".lcm" && looks_like_event_log(file)) logs.push_back(file);
  }
  std::sort(logs.begin(), logs.end());
  return logs;
}

Result<std::unique_ptr<FrameSource>> open_logs(const std::vector<std::string>& files, const RecordingOptions& options) {
  Result<Contents> read = read_logs(files, options);
  if (!read) return read.error();
  Contents& contents = *read;
  const auto chosen = choose_pairs(static_cast<std::int64_t>(contents.pairs.size()), options);
  if (!chosen) return chosen.error();
  std::vector<LoggedPair> pairs;
  for (const std::int64_t i : *chosen) pairs.push_back(contents.pairs[static_cast<std::size_t>(i)]);
  contents.pairs = std::move(pairs);
  read_stamps(contents);
  std::vector<TimestampNs> recorded;
  for (std::size_t i = 0; i < contents.pairs.size(); ++i) {
    const auto number = static_cast<std::size_t>((*chosen)[i]);
    recorded.push_back(options.rate_hz ? stamp_at(number, *options.rate_hz) : contents.pairs[i].stamp_ns);
  }
  auto stamps = make_rising(recorded, options.path);
  if (!stamps) return stamps.error();

  const auto size = size_of_first(contents);
  if (!size) return size.error();
  if (options.calibration.empty() && !options.calibration_options.empty()) {
    return Error{"log has its calibration in it", options.path,
                 "baseline unit, lens and rectified are for a calibration file: name it, or leave them out"};
  }
  SourceInfo info;
  if (!options.calibration.empty()) {
    if (!contents.calibrations.empty()) info = std::move(contents.calibrations.front());
    CalibrationRequest request;
    request.path = options.calibration;
    request.width = size->first;
    request.height = size->second;
    request.options = options.calibration_options;
    std::vector<EventLogReader> again;
    for (const EventLogReader& log : contents.files) {
      auto reader = EventLogReader::open(log.path());
      if (!reader) return reader.error();
      again.push_back(std::move(*reader));
    }
    LoggedPairs store(std::move(again), contents.pairs, *chosen, size->first, size->second);
    auto calibration = calibrate(request, store);
    if (!calibration) return calibration.error();
    info.calibration = std::move(*calibration);
  } else {
    const auto which = calibration_of(contents, *chosen, options);
    if (!which) return which.error();
    info = std::move(contents.calibrations[static_cast<std::size_t>(*which)]);
    if (info.width != size->first || info.height != size->second) {
      return size_error(options.path, info.width, info.height, size->first, size->second);
    }
  }
  info.width = size->first;
  info.height = size->second;
  if (const double rate_hz = rate_of(*stamps); rate_hz > 0.0) info.rate_hz = rate_hz;
  info.frame_count = options.pingpong ? -1 : static_cast<std::int64_t>(contents.pairs.size());
  info.description = describe_log(options, files.size(), contents.damage);
  if (!options.left_mask.empty() || !options.right_mask.empty()) {
    if (auto ok = read_masks(options.left_mask, options.right_mask, "", info); !ok) return ok.error();
  }
  auto store = std::make_unique<LoggedPairs>(std::move(contents.files), std::move(contents.pairs), *chosen, info.width,
                                             info.height);
  return play_pairs(std::move(store), {}, std::move(*stamps), std::move(info), options);
}

}  // namespace cliquevo::drivers
