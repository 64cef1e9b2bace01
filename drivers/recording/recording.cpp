// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording.h"

#include <filesystem>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "drivers/calibration/calibration.h"
#include "drivers/images/image_reader.h"
#include "drivers/images/masks.h"
#include "drivers/recording/bag_set.h"
#include "drivers/recording/image_survey.h"
#include "drivers/recording/layout.h"
#include "drivers/recording/pair_store.h"
#include "drivers/recording/pairing.h"
#include "drivers/recording/video_recording.h"
#include "drivers/text_file.h"

namespace cliquevo::drivers {

namespace {

// Reads the two images of a pair, from two files or from the halves of one.
class PairFiles {
 public:
  explicit PairFiles(bool side_by_side) : side_by_side_(side_by_side) {}

  Result<void> read(const ImagePair& files, Image<std::uint8_t>& left, Image<std::uint8_t>& right) {
    if (files.right.empty()) {
      return Error{"image has no partner in the other camera", files.left, "copy the recording again"};
    }
    if (side_by_side_) return read_halves(files.left, left, right);
    if (auto ok = reader_.read(files.left, left); !ok) return ok;
    return reader_.read(files.right, right);
  }
  std::int64_t warned() const { return reader_.warned(); }
  void set_shift(int shift) { reader_.set_shift(shift); }

 private:
  Result<void> read_halves(const std::string& path, Image<std::uint8_t>& left, Image<std::uint8_t>& right) {
    if (auto ok = reader_.read(path, both_); !ok) return ok;
    if (both_.width() % 2 != 0) {
      return Error{"side-by-side image has an odd width", path, "both halves must be of one size"};
    }
    const int half = both_.width() / 2;
    const ImageView<const std::uint8_t> view = both_.cview();
    left.copy_from({view.data, half, view.height, view.stride});
    right.copy_from({view.data + half, half, view.height, view.stride});
    return {};
  }

  bool side_by_side_;
  ImageReader reader_;
  Image<std::uint8_t> both_;
};

// Pairs of image files.
class ImageFiles final : public PairStore {
 public:
  ImageFiles(std::vector<ImagePair> pairs, bool side_by_side, int width, int height)
      : pairs_(std::move(pairs)), files_(side_by_side), width_(width), height_(height) {}

  std::int64_t size() const override { return static_cast<std::int64_t>(pairs_.size()); }
  std::string name(std::int64_t i) const override { return pairs_[static_cast<std::size_t>(i)].left; }
  Result<void> load(std::int64_t i, StereoPair& pair) override {
    const ImagePair& files = pairs_[static_cast<std::size_t>(i)];
    if (auto ok = files_.read(files, pair.left, pair.right); !ok) return ok;
    if (auto ok = check_size(pair.left, files.left); !ok) return ok;
    return check_size(pair.right, files.right);
  }
  std::int64_t warned() const override { return files_.warned(); }
  void set_shift(int shift) { files_.set_shift(shift); }

 private:
  Result<void> check_size(const Image<std::uint8_t>& image, const std::string& path) const {
    if (image.width() == width_ && image.height() == height_) return {};
    return Error{"image has another size than the recording", path,
                 fmt::format("it is {}x{}, the others are {}x{}: replace it or choose pairs of one size", image.width(),
                             image.height(), width_, height_)};
  }

  std::vector<ImagePair> pairs_;
  PairFiles files_;
  int width_;
  int height_;
};

// Size of the first pair that can be read (a torn one is next()'s to report).
Result<std::pair<int, int>> find_size(const std::vector<ImagePair>& pairs, bool side_by_side) {
  PairFiles files(side_by_side);
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
  std::optional<Error> first_error;
  for (const ImagePair& pair : pairs) {
    if (auto ok = files.read(pair, left, right); !ok) {
      if (!first_error) first_error = ok.error();
      continue;
    }
    if (left.width() != right.width() || left.height() != right.height()) {
      return Error{"cameras have images of unequal size", pair.right,
                   fmt::format("left is {}x{}, right is {}x{}: use images of one size", left.width(), left.height(),
                               right.width(), right.height())};
    }
    if (left.width() < 16 || left.height() < 16) {
      return Error{"image is too small", pair.left, "use images of at least 16 px a side"};
    }
    return std::pair<int, int>{left.width(), left.height()};
  }
  return *first_error;
}

// The number in the first name, where all count on from it.
std::int64_t first_number_of(const Pairing& pairing) {
  std::int64_t first = 0;
  for (std::size_t i = 0; i < pairing.pairs.size(); ++i) {
    const std::string name = std::filesystem::path(pairing.pairs[i].left).stem().string();
    const auto number = name.size() <= 12 ? parse_integer(name) : std::nullopt;
    if (!number || *number < 0) return 0;
    if (i == 0) first = *number;
    if (*number != first + static_cast<std::int64_t>(i)) return 0;
  }
  return first;
}

// Of one folder for both: of their first images.
StreamNames streams_of(const Layout& layout) {
  if (layout.left.folder != layout.right.folder || layout.left.images.empty() || layout.right.images.empty()) {
    return {layout.left.folder, layout.right.folder};
  }
  return {layout.left.images.front().name, layout.right.images.front().name};
}

std::string describe_layout(const Layout& layout, const Pairing& pairing) {
  std::string out = layout.description;
  if (pairing.unpaired > 0) out += fmt::format(" ({} images without a partner)", pairing.unpaired);
  for (const std::string& note : layout.notes) out += fmt::format(" ({})", note);
  return out;
}

}  // namespace

Result<std::unique_ptr<FrameSource>> open_recording(const RecordingOptions& options) {
  if (const std::vector<std::string> logs = find_logs(options.path); !logs.empty()) return open_logs(logs, options);
  if (const std::vector<std::string> bags = find_bags(options.path); !bags.empty()) return open_bags(bags, options);
  const Result<VideoFiles> videos = find_videos(options.path);
  if (!videos) return videos.error();
  if (!videos->empty()) return open_videos(*videos, options);
  const Result<Layout> layout = find_layout(options.path, options.side_by_side);
  if (!layout) return layout.error();
  const Result<Pairing> pairing = pair_images(*layout, options.rate_hz, options.pair_tolerance_s);
  if (!pairing) return pairing.error();
  const auto chosen = choose_pairs(static_cast<std::int64_t>(pairing->pairs.size()), options);
  if (!chosen) return chosen.error();
  std::vector<ImagePair> pairs;
  std::vector<TimestampNs> recorded;
  for (const std::int64_t i : *chosen) {
    pairs.push_back(pairing->pairs[static_cast<std::size_t>(i)]);
    recorded.push_back(pairs.back().stamp_ns);
  }
  auto stamps = make_rising(recorded, options.path);
  if (!stamps) return stamps.error();

  SourceInfo info;
  info.description = describe_layout(*layout, *pairing);
  const Result<std::pair<int, int>> size = find_size(pairs, layout->side_by_side);
  if (!size) return size.error();
  info.width = size->first;
  info.height = size->second;
  info.frame_count = options.pingpong ? -1 : static_cast<std::int64_t>(pairs.size());
  info.first_number = first_number_of(*pairing);
  info.rate_hz = rate_of(*stamps);
  if (info.rate_hz <= 0.0) info.rate_hz = options.rate_hz.value_or(0.0);

  CalibrationRequest request;
  request.path = options.calibration.empty() ? layout->calibration : options.calibration;
  if (request.path.empty() && options.needs_calibration) {
    return missing_calibration(options.path);
  }
  request.width = info.width;
  request.height = info.height;
  request.left_camera = layout->left_camera;
  request.right_camera = layout->right_camera;
  request.options = options.calibration_options;
  const DepthSurvey depth = survey_depth(pairs);
  if (depth.deep) info.description += ", " + describe_depth(depth);
  auto store = std::make_unique<ImageFiles>(std::move(pairs), layout->side_by_side, info.width, info.height);
  if (depth.deep) store->set_shift(depth.shift);
  if (options.needs_calibration) {
    Result<StereoCalibration> calibration = calibrate(request, *store);
    if (!calibration) return calibration.error();
    info.calibration = std::move(*calibration);
  }
  if (auto ok = read_masks(options.left_mask, options.right_mask, layout->root, info); !ok) return ok.error();
  return play_pairs(std::move(store), streams_of(*layout), std::move(*stamps), std::move(info), options);
}

}  // namespace cliquevo::drivers
