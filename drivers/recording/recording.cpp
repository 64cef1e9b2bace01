// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording.h"

#include <filesystem>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "drivers/calibration/calibration.h"
#include "drivers/masks.h"
#include "drivers/recording/image_reader.h"
#include "drivers/recording/layout.h"
#include "drivers/recording/pair_store.h"
#include "drivers/recording/pairing.h"

namespace cliquevo::drivers {

namespace {

// Pairs of image files.
class ImageFiles final : public PairStore {
 public:
  explicit ImageFiles(std::vector<ImagePair> pairs) : pairs_(std::move(pairs)) {}

  std::int64_t size() const override { return static_cast<std::int64_t>(pairs_.size()); }
  TimestampNs stamp_ns(std::int64_t i) const override { return pairs_[static_cast<std::size_t>(i)].stamp_ns; }
  Result<void> load(std::int64_t i, StereoPair& pair) override {
    const ImagePair& files = pairs_[static_cast<std::size_t>(i)];
    if (auto ok = read(files.left, pair.left); !ok) return ok;
    return read(files.right, pair.right);
  }
  void expect_size(int width, int height) { width_ = width, height_ = height; }

 private:
  Result<void> read(const std::string& path, Image<std::uint8_t>& image) {
    if (auto ok = reader_.read(path, image); !ok) return ok;
    if (image.width() == width_ && image.height() == height_) return {};
    return Error{"image has another size than the recording", path,
                 fmt::format("it is {}x{}, the others are {}x{}: replace it or choose pairs of one size", image.width(),
                             image.height(), width_, height_)};
  }

  std::vector<ImagePair> pairs_;
  int width_ = 0;
  int height_ = 0;
  ImageReader reader_;
};

// Size of the first pair that can be read (a torn one is next()'s to report).
Result<std::pair<int, int>> find_size(const std::vector<ImagePair>& pairs) {
  ImageReader reader;
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
  std::optional<Error> first_error;
  for (const ImagePair& pair : pairs) {
    Result<void> ok = reader.read(pair.left, left);
    if (ok) ok = reader.read(pair.right, right);
    if (!ok) {
      if (!first_error) first_error = ok.error();
      continue;
    }
    if (left.width() != right.width() || left.height() != right.height()) {
      return Error{"eyes have images of unequal size", pair.right,
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

}  // namespace

Result<std::unique_ptr<FrameSource>> open_recording(const RecordingOptions& options) {
  if (const std::vector<std::string> logs = find_logs(options.path); !logs.empty()) return open_logs(logs, options);
  const Result<Layout> layout = find_layout(options.path);
  if (!layout) return layout.error();
  const Result<Pairing> pairing = pair_images(*layout, options.rate_hz, options.pair_tolerance_s);
  if (!pairing) return pairing.error();
  const auto chosen = choose_pairs(static_cast<std::int64_t>(pairing->pairs.size()), options);
  if (!chosen) return chosen.error();
  std::vector<ImagePair> pairs;
  for (const std::int64_t i : *chosen) pairs.push_back(pairing->pairs[static_cast<std::size_t>(i)]);

  SourceInfo info;
  info.description = layout->description;
  if (pairing->unpaired > 0) info.description += fmt::format(" ({} images without a partner)", pairing->unpaired);
  const Result<std::pair<int, int>> size = find_size(pairs);
  if (!size) return size.error();
  info.width = size->first;
  info.height = size->second;
  info.frame_count = options.pingpong ? -1 : static_cast<std::int64_t>(pairs.size());
  std::vector<TimestampNs> stamps;
  for (const ImagePair& pair : pairs) stamps.push_back(pair.stamp_ns);
  const std::int64_t period_ns = median_period_ns(stamps);
  info.rate_hz = period_ns > 0 ? 1e9 / static_cast<double>(period_ns) : options.rate_hz.value_or(0.0);

  CalibrationRequest request;
  request.path = options.calibration.empty() ? layout->calibration : options.calibration;
  if (request.path.empty()) {
    return Error{"recording has no calibration", options.path, "name one with --calibration FILE"};
  }
  request.width = info.width;
  request.height = info.height;
  request.left_camera = layout->left_camera;
  request.right_camera = layout->right_camera;
  request.options = options.calibration_options;
  auto store = std::make_unique<ImageFiles>(std::move(pairs));
  store->expect_size(info.width, info.height);
  Result<StereoCalibration> calibration = calibrate(request, *store);
  if (!calibration) return calibration.error();
  info.calibration = std::move(*calibration);
  if (auto ok = read_masks(options.left_mask, options.right_mask, layout->root, info); !ok) return ok.error();
  return play_pairs(std::move(store), std::move(info), options);
}

}  // namespace cliquevo::drivers
