// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/streams.h"

#include <algorithm>
#include <map>

#include <fmt/format.h>

#include "core/base/saturating.h"
#include "drivers/recording/bag_set.h"
#include "drivers/recording/event_log.h"
#include "drivers/recording/layout.h"
#include "drivers/recording/pair_store.h"
#include "drivers/recording/pairing.h"
#include "drivers/recording/times_file.h"
#include "drivers/recording/video_recording.h"
#include "drivers/video/open_video.h"

namespace cliquevo::drivers {

namespace {

RecordedStream measure(std::string name, std::string type, std::vector<TimestampNs> stamps, std::int64_t count) {
  RecordedStream out;
  out.name = std::move(name);
  out.type = std::move(type);
  out.count = count;
  if (stamps.empty()) return out;
  for (TimestampNs& stamp : stamps) stamp = std::clamp(stamp, -kMostStampNs, kMostStampNs);
  std::sort(stamps.begin(), stamps.end());
  out.first_ns = stamps.front();
  out.last_ns = stamps.back();
  const std::int64_t period_ns = median_period_ns(stamps);
  if (period_ns <= 0) return out;
  out.rate_hz = 1e9 / static_cast<double>(period_ns);
  for (std::size_t i = 1; i < stamps.size(); ++i) {
    const std::int64_t step_ns = stamps[i] - stamps[i - 1];
    if (step_ns <= saturated_sum(period_ns, period_ns / 2)) continue;
    ++out.gaps;
    out.longest_gap_s = std::max(out.longest_gap_s, static_cast<double>(step_ns) * 1e-9);
  }
  return out;
}

Result<RecordedStreams> streams_of_logs(const std::vector<std::string>& paths) {
  RecordedStreams out;
  out.kind = "LCM log";
  std::map<std::string, std::vector<TimestampNs>> channels;
  LogDamage damage;
  for (const std::string& path : paths) {
    auto log = EventLogReader::open(path);
    if (!log) return log.error();
    constexpr std::int64_t kMostUs = kMostStampNs / 1000;
    const LogDamage found = log->scan([&](std::string_view channel, const LoggedEvent& event) {
      channels[std::string(channel)].push_back(std::clamp(event.utime, -kMostUs, kMostUs) * 1000);
    });
    damage.torn_tail += found.torn_tail;
    damage.broken_places += found.broken_places;
  }
  for (auto& [name, stamps] : channels) {
    const auto count = static_cast<std::int64_t>(stamps.size());
    out.streams.push_back(measure(name, "LCM messages", std::move(stamps), count));
  }
  if (damage.torn_tail > 0) out.damage = fmt::format("cut off: {} bytes behind its last whole event", damage.torn_tail);
  if (damage.broken_places > 0) {
    out.damage += fmt::format("{}damaged in {} places", out.damage.empty() ? "" : "; ", damage.broken_places);
  }
  return out;
}

Result<RecordedStreams> streams_of_bags(const std::vector<std::string>& paths) {
  auto bags = BagSet::open(paths);
  if (!bags) return bags.error();
  RecordedStreams out;
  out.kind = bags->files().front()->kind();
  std::map<std::pair<std::string, std::string>, std::vector<TimestampNs>> stamps;
  for (const auto& bag : bags->files()) {
    for (const BagMessage& m : bag->messages()) {
      const BagTopic& topic = bag->topics()[m.topic];
      stamps[{topic.name, topic.type}].push_back(m.received_ns);
    }
    if (!bag->damage().empty()) out.damage += (out.damage.empty() ? "" : "; ") + bag->damage();
  }
  for (const SetTopic& t : bags->topics()) {
    out.streams.push_back(
        measure(t.topic.name, t.topic.type, std::move(stamps[{t.topic.name, t.topic.type}]), t.count));
  }
  return out;
}

Result<RecordedStreams> streams_of_videos(const VideoFiles& files) {
  RecordedStreams out;
  out.kind = files.right.empty() ? "side-by-side video" : "two videos";
  for (const std::string& path : {files.left, files.right}) {
    if (path.empty()) continue;
    auto video = open_video(path);
    if (!video) return video.error();
    const VideoInfo& info = (*video)->info();
    out.streams.push_back(measure(path, fmt::format("{} {}x{}", info.codec, info.width, info.height), info.stamps_ns,
                                  static_cast<std::int64_t>(info.stamps_ns.size())));
  }
  return out;
}

Result<RecordedStreams> streams_of_folder(const RecordingOptions& options) {
  const Result<Layout> layout = find_layout(options.path, options.side_by_side);
  if (!layout) return layout.error();
  RecordedStreams out;
  out.kind = layout->description;
  for (const ImageList* list : {&layout->left, &layout->right}) {
    if (layout->side_by_side && list == &layout->right) continue;
    std::vector<TimestampNs> stamps;
    for (const RecordedImage& image : list->images) {
      if (image.stamp_ns) stamps.push_back(*image.stamp_ns);
    }
    out.streams.push_back(
        measure(list->folder, "images", std::move(stamps), static_cast<std::int64_t>(list->images.size())));
  }
  return out;
}

}  // namespace

Result<RecordedStreams> list_streams(const RecordingOptions& options) {
  if (const auto logs = find_logs(options.path); !logs.empty()) return streams_of_logs(logs);
  if (const auto bags = find_bags(options.path); !bags.empty()) return streams_of_bags(bags);
  const Result<VideoFiles> videos = find_videos(options.path);
  if (!videos) return videos.error();
  return videos->empty() ? streams_of_folder(options) : streams_of_videos(*videos);
}

}  // namespace cliquevo::drivers
