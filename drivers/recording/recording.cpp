// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <condition_variable>
#include <cstdlib>
#include <filesystem>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "drivers/recording/calibration_common.h"
#include "drivers/recording/image_reader.h"
#include "drivers/recording/layout.h"
#include "drivers/recording/pairing.h"

namespace cliquevo::drivers {

namespace {

// Reads pair after pair from the disk; one thread at a time.
class PairReader {
 public:
  PairReader(std::vector<ImagePair> pairs, const RecordingOptions& options, int width, int height)
      : pairs_(std::move(pairs)), options_(options), width_(width), height_(height) {
    std::vector<TimestampNs> stamps;
    for (const ImagePair& pair : pairs_) stamps.push_back(pair.stamp_ns);
    period_ns_ = median_period_ns(stamps);
    if (period_ns_ <= 0) period_ns_ = 100'000'000;  // a single pair over and over
  }

  Result<bool> next(StereoPair& pair) {
    const auto count = static_cast<std::int64_t>(pairs_.size());
    if (!options_.pingpong && position_ >= count) return false;
    const std::int64_t k = position_++;
    const std::int64_t turn = std::max<std::int64_t>(1, 2 * (count - 1));
    const std::int64_t i = k % turn < count ? k % turn : turn - k % turn;
    const ImagePair& files = pairs_[static_cast<std::size_t>(i)];
    if (k == 0) {
      stamp_ns_ = files.stamp_ns;
    } else {
      stamp_ns_ += count == 1 ? period_ns_ : std::abs(files.stamp_ns - last_file_stamp_ns_);
    }
    last_file_stamp_ns_ = files.stamp_ns;
    pair.index = options_.first + k * options_.every;
    pair.stamp_ns = stamp_ns_;
    pair.truth_T_world_camera.reset();
    if (auto ok = read(files.left, pair.left); !ok) return ok.error();
    if (auto ok = read(files.right, pair.right); !ok) return ok.error();
    return true;
  }

 private:
  Result<void> read(const std::string& path, Image<std::uint8_t>& image) {
    if (auto ok = reader_.read(path, image); !ok) return ok;
    if (image.width() == width_ && image.height() == height_) return {};
    return Error{"image has another size than the recording", path,
                 fmt::format("it is {}x{}, the others are {}x{}: replace it or choose pairs of one size", image.width(),
                             image.height(), width_, height_)};
  }

  std::vector<ImagePair> pairs_;
  RecordingOptions options_;
  int width_;
  int height_;
  std::int64_t period_ns_ = 0;
  std::int64_t position_ = 0;
  TimestampNs stamp_ns_ = 0;
  TimestampNs last_file_stamp_ns_ = 0;
  ImageReader reader_;
};

class Recording final : public FrameSource {
 public:
  Recording(SourceInfo info, PairReader reader, bool read_ahead) : info_(std::move(info)), reader_(std::move(reader)) {
    if (read_ahead) thread_ = std::thread([this] { fill(); });
  }
  ~Recording() override {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    if (thread_.joinable()) thread_.join();
  }
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;

  const SourceInfo& info() const override { return info_; }

  Result<bool> next(StereoPair& pair) override {
    if (!thread_.joinable()) return reader_.next(pair);
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return filled_ > 0 || ended_; });
    if (filled_ == 0) return false;
    Slot& slot = slots_[taken_ % slots_.size()];
    // The storage changes hands both ways: nothing is copied, nothing allocated.
    std::swap(pair, slot.pair);
    Result<bool> result = std::move(slot.result);
    ++taken_;
    --filled_;
    lock.unlock();
    changed_.notify_all();
    return result;
  }

 private:
  struct Slot {
    StereoPair pair;
    Result<bool> result = false;
  };

  void fill() {
    for (std::size_t k = 0;; ++k) {
      Slot& slot = slots_[k % slots_.size()];
      {
        std::unique_lock<std::mutex> lock(mutex_);
        changed_.wait(lock, [this] { return stop_ || filled_ < slots_.size(); });
        if (stop_) return;
      }
      slot.result = reader_.next(slot.pair);
      const bool end = slot.result.ok() && !*slot.result;
      {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (end) {
          ended_ = true;
        } else {
          ++filled_;
        }
      }
      changed_.notify_all();
      if (end) return;
    }
  }

  SourceInfo info_;
  PairReader reader_;  // the thread's when there is one
  std::array<Slot, 3> slots_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::size_t filled_ = 0;
  std::size_t taken_ = 0;
  bool ended_ = false;
  bool stop_ = false;
  std::thread thread_;
};

Result<void> check_options(const RecordingOptions& o) {
  const auto bad = [&](const std::string& what, const std::string& remedy) { return Error{what, o.path, remedy}; };
  if (o.first < 0) return bad("first pair is negative", "count pairs from 0");
  if (o.last < -1 || (o.last >= 0 && o.last < o.first)) return bad("last pair is before the first", "swap them");
  if (o.every < 1) return bad("every is below 1", "give 1 for all pairs, 2 for every second");
  if (o.rate_hz && !(*o.rate_hz >= 1e-3 && *o.rate_hz <= 1e6)) {
    return bad("frame rate is out of 0.001 to 1000000 Hz", "give the rate in Hz");
  }
  if (o.pair_tolerance_s && !(*o.pair_tolerance_s >= 0.0 && *o.pair_tolerance_s <= 3600.0)) {
    return bad("pair tolerance is out of 0 to 3600 s", "give it in seconds");
  }
  return {};
}

Result<std::vector<ImagePair>> choose(const std::vector<ImagePair>& pairs, const RecordingOptions& o) {
  const auto count = static_cast<std::int64_t>(pairs.size());
  if (o.first >= count) {
    return Error{"first pair is behind the end", o.path, fmt::format("the recording has pairs 0 to {}", count - 1)};
  }
  if (o.last >= count) {
    return Error{"last pair is behind the end", o.path, fmt::format("the recording has pairs 0 to {}", count - 1)};
  }
  const std::int64_t last = o.last < 0 ? count - 1 : o.last;
  std::vector<ImagePair> chosen;
  for (std::int64_t i = o.first; i <= last; i += o.every) chosen.push_back(pairs[static_cast<std::size_t>(i)]);
  return chosen;
}

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

Result<void> read_mask(const std::string& given, const std::string& root, const char* name, SourceInfo& info,
                       Image<std::uint8_t>& mask) {
  std::error_code ec;
  std::string path = given;
  if (path.empty()) {
    path = (std::filesystem::path(root) / name).string();
    if (!std::filesystem::exists(path, ec)) return {};
  }
  ImageReader reader;
  if (auto ok = reader.read(path, mask); !ok) {
    return Error{"cannot read mask", path, ok.error().remedy};
  }
  if (mask.width() != info.width || mask.height() != info.height) {
    return Error{"mask has another size than the images", path,
                 fmt::format("it is {}x{}, the images are {}x{}: draw it on an image of this recording", mask.width(),
                             mask.height(), info.width, info.height)};
  }
  return {};
}

}  // namespace

Result<std::unique_ptr<FrameSource>> open_recording(const RecordingOptions& options) {
  if (auto ok = check_options(options); !ok) return ok.error();
  const Result<Layout> layout = find_layout(options.path);
  if (!layout) return layout.error();
  const Result<Pairing> pairing = pair_images(*layout, options.rate_hz, options.pair_tolerance_s);
  if (!pairing) return pairing.error();
  Result<std::vector<ImagePair>> pairs = choose(pairing->pairs, options);
  if (!pairs) return pairs.error();

  SourceInfo info;
  info.description = layout->description;
  if (pairing->unpaired > 0) info.description += fmt::format(" ({} images without a partner)", pairing->unpaired);
  const Result<std::pair<int, int>> size = find_size(*pairs);
  if (!size) return size.error();
  info.width = size->first;
  info.height = size->second;
  info.frame_count = options.pingpong ? -1 : static_cast<std::int64_t>(pairs->size());
  std::vector<TimestampNs> stamps;
  for (const ImagePair& pair : *pairs) stamps.push_back(pair.stamp_ns);
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
  Result<StereoCalibration> calibration = read_calibration(request);
  if (!calibration) return calibration.error();
  info.calibration = std::move(*calibration);
  if (auto ok = read_mask(options.left_mask, layout->root, "mask_left.png", info, info.left_mask); !ok) {
    return ok.error();
  }
  if (auto ok = read_mask(options.right_mask, layout->root, "mask_right.png", info, info.right_mask); !ok) {
    return ok.error();
  }
  PairReader reader(std::move(*pairs), options, info.width, info.height);
  return std::unique_ptr<FrameSource>(
      std::make_unique<Recording>(std::move(info), std::move(reader), options.read_ahead));
}

}  // namespace cliquevo::drivers
