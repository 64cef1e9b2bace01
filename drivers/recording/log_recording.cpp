// SPDX-License-Identifier: BSD-3-Clause
// LCM event logs as recordings.
#include <algorithm>
#include <filesystem>
#include <map>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "drivers/calibration/checks.h"
#include "drivers/masks.h"
#include "drivers/recording/calibration_message.h"
#include "drivers/recording/event_log.h"
#include "drivers/recording/pair_store.h"
#include "drivers/recording/pairing.h"
#include "drivers/recording/stereo_message.h"

namespace cliquevo::drivers {

namespace fs = std::filesystem;

namespace {

// A pair in one of the logs.
struct LoggedPair {
  std::size_t file = 0;
  LoggedEvent event;
  TimestampNs stamp_ns = 0;
};

struct Contents {
  std::vector<EventLogReader> files;
  std::vector<LoggedPair> pairs;
  std::optional<SourceInfo> info;  // of the first calibration
  LogDamage damage;
};

class LoggedPairs final : public PairStore {
 public:
  LoggedPairs(std::vector<EventLogReader> files, std::vector<LoggedPair> pairs, int width, int height)
      : files_(std::move(files)), pairs_(std::move(pairs)), width_(width), height_(height) {}

  std::int64_t size() const override { return static_cast<std::int64_t>(pairs_.size()); }
  TimestampNs stamp_ns(std::int64_t i) const override { return pairs_[static_cast<std::size_t>(i)].stamp_ns; }
  Result<void> load(std::int64_t i, StereoPair& pair) override {
    const LoggedPair& at = pairs_[static_cast<std::size_t>(i)];
    const EventLogReader& file = files_[at.file];
    if (auto ok = file.read(at.event, bytes_); !ok) return ok;
    const std::string name = fmt::format("{}, pair {}", file.path(), i);
    const auto message = parse_stereo(bytes_.data(), bytes_.size(), name);
    if (!message) return message.error();
    for (const StereoMessageEye* eye : {&message->left, &message->right}) {
      if (eye->image.same_size(width_, height_)) continue;
      return Error{"image has another size than the recording", name,
                   fmt::format("it is {}x{}, the others are {}x{}: choose pairs of one size", eye->image.width,
                               eye->image.height, width_, height_)};
    }
    pair.left.copy_from(message->left.image);
    pair.right.copy_from(message->right.image);
    pair.right_offset_ns = message->right.stamp_ns - message->left.stamp_ns;
    pair.host_ns = message->left.host_ns;
    return {};
  }

 private:
  std::vector<EventLogReader> files_;
  std::vector<LoggedPair> pairs_;
  int width_;
  int height_;
  std::vector<std::uint8_t> bytes_;
};

// Pairs are on the channel that we write, else on the one channel that carries stereo messages.
class Collector {
 public:
  void add(const EventLogReader& file, std::size_t number, std::string_view channel, const LoggedEvent& event,
           Contents& contents) {
    if (channel == kCalibrationChannel && !contents.info) {
      if (!file.read(event, bytes_)) return;
      auto info = parse_calibration_message(bytes_.data(), bytes_.size(), file.path());
      if (info) {
        contents.info = std::move(*info);
      } else if (!calibration_error) {
        calibration_error = info.error();
      }
      return;
    }
    auto known = channels_.find(channel);
    if (known == channels_.end()) {
      const bool images = file.read(event, bytes_, 8).ok() && is_images_message(bytes_.data(), bytes_.size());
      known = channels_.emplace(std::string(channel), images).first;
    }
    if (known->second) pairs_[known->first].push_back({number, event, 0});
  }
  std::vector<LoggedPair> pairs() {
    const auto ours = pairs_.find(kStereoChannel);
    if (ours != pairs_.end()) return std::move(ours->second);
    return pairs_.empty() ? std::vector<LoggedPair>{} : std::move(pairs_.begin()->second);
  }
  std::optional<Error> calibration_error;

 private:
  std::map<std::string, bool, std::less<>> channels_;  // whether it carries images
  std::map<std::string, std::vector<LoggedPair>> pairs_;
  std::vector<std::uint8_t> bytes_;
};

// A damaged log may hold any number.
TimestampNs from_us(std::int64_t us) {
  constexpr std::int64_t kMostUs = INT64_MAX / 1000;
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
    pair.stamp_ns = parse_stereo_stamp(bytes.data(), bytes.size()).value_or(pair.stamp_ns);
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
  contents.pairs = collector.pairs();
  if (contents.pairs.empty()) {
    return Error{"no stereo pair in the log", options.path, "name a log with images_t messages (VO_STEREO)"};
  }
  if (!contents.info && options.calibration.empty()) {
    if (collector.calibration_error) return *collector.calibration_error;
    return Error{"recording has no calibration", options.path, "name one with --calibration FILE"};
  }
  return contents;
}

Result<std::pair<int, int>> size_of_first(const Contents& contents) {
  std::vector<std::uint8_t> bytes;
  std::optional<Error> error;
  for (const LoggedPair& pair : contents.pairs) {
    const EventLogReader& file = contents.files[pair.file];
    if (auto ok = file.read(pair.event, bytes); !ok) return ok.error();
    const auto message = parse_stereo(bytes.data(), bytes.size(), file.path());
    if (message) return std::pair{message->left.image.width, message->left.image.height};
    if (!error) error = message.error();
  }
  return *error;
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

  const auto size = size_of_first(contents);
  if (!size) return size.error();
  if (options.calibration.empty() && !options.calibration_options.empty()) {
    return Error{"log has its calibration in it", options.path,
                 "baseline unit, lens and rectified are for a calibration file: name it, or leave them out"};
  }
  SourceInfo info = contents.info ? std::move(*contents.info) : SourceInfo{};
  if (!options.calibration.empty()) {
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
    LoggedPairs store(std::move(again), contents.pairs, size->first, size->second);
    auto calibration = calibrate(request, store);
    if (!calibration) return calibration.error();
    info.calibration = std::move(*calibration);
  } else if (info.width != size->first || info.height != size->second) {
    return size_error(options.path, info.width, info.height, size->first, size->second);
  }
  info.width = size->first;
  info.height = size->second;
  std::vector<TimestampNs> stamps;
  for (const LoggedPair& pair : contents.pairs) stamps.push_back(pair.stamp_ns);
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    if (stamps[i] > stamps[i - 1]) continue;
    return Error{"stamps do not rise", fmt::format("{}, pair {}", options.path, (*chosen)[i]),
                 "play the recordings in the log one at a time: name a single file, or choose first and last"};
  }
  const std::int64_t period_ns = median_period_ns(stamps);
  if (period_ns > 0) info.rate_hz = 1e9 / static_cast<double>(period_ns);
  info.frame_count = options.pingpong ? -1 : static_cast<std::int64_t>(contents.pairs.size());
  info.description = fmt::format("LCM log {}", options.path);
  if (files.size() > 1) info.description += fmt::format(" ({} files)", files.size());
  if (contents.damage.torn_tail > 0) {
    info.description += fmt::format(" (cut off: {} bytes behind its last whole event)", contents.damage.torn_tail);
  }
  if (contents.damage.broken_places > 0) {
    info.description += fmt::format(" (damaged in {} places: events left out)", contents.damage.broken_places);
  }
  if (!options.left_mask.empty() || !options.right_mask.empty()) {
    if (auto ok = read_masks(options.left_mask, options.right_mask, "", info); !ok) return ok.error();
  }
  auto store =
      std::make_unique<LoggedPairs>(std::move(contents.files), std::move(contents.pairs), info.width, info.height);
  return play_pairs(std::move(store), std::move(info), options);
}

}  // namespace cliquevo::drivers
