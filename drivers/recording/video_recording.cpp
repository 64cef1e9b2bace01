// SPDX-License-Identifier: BSD-3-Clause
// Video files as recordings: one with both cameras' pictures side by side, or one a camera.
#include "drivers/recording/video_recording.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "drivers/calibration/calibration.h"
#include "drivers/images/masks.h"
#include "drivers/recording/layout.h"
#include "drivers/recording/pair_store.h"
#include "drivers/recording/pairing.h"
#include "drivers/recording/side_words.h"
#include "drivers/video/open_video.h"

namespace cliquevo::drivers {

namespace {

namespace fs = std::filesystem;

struct FramePair {
  std::int64_t left = 0;  // number of the frame in its file
  std::int64_t right = 0;
};

class VideoPairs final : public PairStore {
 public:
  // right: null where each frame holds both pictures.
  VideoPairs(std::unique_ptr<VideoReader> left, std::unique_ptr<VideoReader> right, std::vector<FramePair> pairs,
             std::string path)
      : left_(std::move(left)), right_(std::move(right)), pairs_(std::move(pairs)), path_(std::move(path)) {}

  std::int64_t size() const override { return static_cast<std::int64_t>(pairs_.size()); }
  std::string name(std::int64_t i) const override {
    return fmt::format("{}, frame {}", path_, pairs_[static_cast<std::size_t>(i)].left);
  }
  Result<void> load(std::int64_t i, StereoPair& pair) override {
    const FramePair& from = pairs_[static_cast<std::size_t>(i)];
    if (right_ != nullptr) {
      if (auto ok = left_->read(from.left, pair.left); !ok) return ok;
      return right_->read(from.right, pair.right);
    }
    if (auto ok = left_->read(from.left, both_); !ok) return ok;
    const ImageView<const std::uint8_t> view = both_.cview();
    const int half = view.width / 2;
    pair.left.copy_from({view.data, half, view.height, view.stride});
    pair.right.copy_from({view.data + half, half, view.height, view.stride});
    return {};
  }

 private:
  std::unique_ptr<VideoReader> left_;
  std::unique_ptr<VideoReader> right_;
  std::vector<FramePair> pairs_;
  std::string path_;
  Image<std::uint8_t> both_;
};

struct OpenVideos {
  std::unique_ptr<VideoReader> left;
  std::unique_ptr<VideoReader> right;
  int width = 0;  // of one camera's picture
  int height = 0;
};

Result<OpenVideos> open_files(const VideoFiles& files) {
  OpenVideos out;
  auto left = open_video(files.left);
  if (!left) return left.error();
  out.left = std::move(*left);
  out.width = out.left->info().width;
  out.height = out.left->info().height;
  if (files.right.empty()) {
    if (out.width % 2 != 0) {
      return Error{"side-by-side video has an odd width", files.left, "both halves must be of one size"};
    }
    out.width /= 2;
  } else {
    auto right = open_video(files.right);
    if (!right) return right.error();
    out.right = std::move(*right);
    if (out.right->info().width != out.width || out.right->info().height != out.height) {
      return Error{"videos have frames of unequal size", files.right, "use two of one size"};
    }
  }
  if (out.width < 16 || out.height < 16) return Error{"video is too small", files.left, "use at least 16 px a side"};
  return out;
}

// Both start at the same moment; else frames pair by their times.
Result<std::vector<FramePair>> pair_frames(const OpenVideos& videos, const VideoFiles& files,
                                           const RecordingOptions& options) {
  const std::vector<TimestampNs>& left = videos.left->info().stamps_ns;
  std::vector<FramePair> pairs;
  if (videos.right == nullptr) {
    for (std::int64_t i = 0; i < static_cast<std::int64_t>(left.size()); ++i) pairs.push_back({i, i});
    return pairs;
  }
  const std::vector<TimestampNs>& right = videos.right->info().stamps_ns;
  for (const auto& [l, r] : nearest_pairs(left, right, pair_tolerance_ns(options.pair_tolerance_s, left))) {
    pairs.push_back({static_cast<std::int64_t>(l), static_cast<std::int64_t>(r)});
  }
  if (pairs.empty()) {
    return Error{"no frames of the two videos are of one time", files.right, "give a larger --pair-tolerance"};
  }
  return pairs;
}

std::string describe(const OpenVideos& videos, const VideoFiles& files, std::size_t pairs) {
  const VideoInfo& left = videos.left->info();
  if (videos.right == nullptr) return fmt::format("side-by-side video {} ({})", files.left, left.codec);
  std::string out = fmt::format("videos {} and {} ({})", files.left, files.right, left.codec);
  const std::size_t frames = left.stamps_ns.size() + videos.right->info().stamps_ns.size();
  if (frames > 2 * pairs) out += fmt::format(" ({} frames without a partner)", frames - 2 * pairs);
  return out;
}

}  // namespace

Result<VideoFiles> find_videos(const std::string& path) {
  std::error_code ec;
  if (is_video_name(path)) return VideoFiles{path, ""};
  if (const std::size_t comma = path.find(','); comma != std::string::npos && !fs::exists(path, ec)) {
    VideoFiles two{path.substr(0, comma), path.substr(comma + 1)};
    return is_video_name(two.left) && is_video_name(two.right) ? two : VideoFiles{};
  }
  if (!fs::is_directory(path, ec)) return VideoFiles{};
  std::vector<std::string> videos;
  for (fs::directory_iterator entry(path, ec); !ec && entry != fs::directory_iterator(); entry.increment(ec)) {
    if (is_video_name(entry->path().string())) videos.push_back(entry->path().string());
  }
  if (videos.empty() || !folders_with_images(path, 5).empty()) return VideoFiles{};
  std::sort(videos.begin(), videos.end(), natural_less);
  if (videos.size() == 1) return VideoFiles{videos.front(), ""};
  const auto name = [](const std::string& file) { return fs::path(file).stem().string(); };
  if (videos.size() == 2) {
    for (const auto& [l, r] : {std::pair{0, 1}, std::pair{1, 0}}) {
      const VideoFiles two{videos[static_cast<std::size_t>(l)], videos[static_cast<std::size_t>(r)]};
      if (pair_kind(name(two.left), name(two.right))) return two;
    }
  }
  std::string names;
  for (const std::string& file : videos) names += (names.empty() ? "" : ", ") + fs::path(file).filename().string();
  return Error{"folder holds several videos", path, "name one, or LEFT,RIGHT: " + names};
}

Result<std::unique_ptr<FrameSource>> open_videos(const VideoFiles& files, const RecordingOptions& options) {
  auto videos = open_files(files);
  if (!videos) return videos.error();
  const auto all = pair_frames(*videos, files, options);
  if (!all) return all.error();
  const auto chosen = choose_pairs(static_cast<std::int64_t>(all->size()), options);
  if (!chosen) return chosen.error();
  std::vector<FramePair> pairs;
  std::vector<TimestampNs> recorded;
  for (const std::int64_t i : *chosen) {
    const auto number = static_cast<std::size_t>(i);
    pairs.push_back((*all)[number]);
    recorded.push_back(options.rate_hz ? stamp_at(number, *options.rate_hz)
                                       : videos->left->info().stamps_ns[static_cast<std::size_t>(pairs.back().left)]);
  }
  auto stamps = make_rising(recorded, files.left);
  if (!stamps) return stamps.error();
  SourceInfo info;
  info.description = describe(*videos, files, all->size());
  info.width = videos->width;
  info.height = videos->height;
  info.frame_count = options.pingpong ? -1 : static_cast<std::int64_t>(pairs.size());
  info.rate_hz = rate_of(*stamps);
  CalibrationRequest request;
  const std::string folder = fs::path(files.left).parent_path().string();
  request.path = options.calibration.empty() ? find_calibration(folder.empty() ? "." : folder) : options.calibration;
  if (request.path.empty() && options.needs_calibration) {
    return missing_calibration(files.left);
  }
  request.width = info.width;
  request.height = info.height;
  request.options = options.calibration_options;
  auto store =
      std::make_unique<VideoPairs>(std::move(videos->left), std::move(videos->right), std::move(pairs), files.left);
  if (options.needs_calibration) {
    auto calibration = calibrate(request, *store);
    if (!calibration) return calibration.error();
    info.calibration = std::move(*calibration);
  }
  if (auto ok = read_masks(options.left_mask, options.right_mask, folder, info); !ok) return ok.error();
  return play_pairs(std::move(store), {files.left, files.right}, std::move(*stamps), std::move(info), options);
}

}  // namespace cliquevo::drivers
