// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/pair_store.h"

#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/caught.h"
#include "core/base/saturating.h"
#include "drivers/calibration/examine.h"
#include "drivers/recording/image_survey.h"
#include "drivers/recording/pairing.h"
#include "drivers/recording/side_words.h"

namespace cliquevo::drivers {

namespace {

constexpr double kMostRate_hz = 1000.0;  // of pairs of images

// Reads pair after pair from the disk; one thread at a time.
class PairReader {
 public:
  PairReader(std::unique_ptr<PairStore> store, RisingStamps stamps, const RecordingOptions& options, bool mosaic)
      : store_(std::move(store)),
        stamps_(std::move(stamps)),
        options_(options),
        mosaic_(mosaic),
        warned_before_(store_->warned()) {
    for (std::int64_t i = 0; i < store_->size(); ++i) {
      if (!options_.pingpong || !stamps_.skipped[static_cast<std::size_t>(i)]) order_.push_back(i);
    }
    const double rate_hz = rate_of(stamps_);
    if (rate_hz > 0.0) period_ns_ = static_cast<std::int64_t>(1e9 / rate_hz);
    // Beyond the recording's length it makes no difference, and must not overflow.
    every_ = std::min(options_.every, std::max<std::int64_t>(1, store_->size()));
  }

  Result<bool> next(StereoPair& pair) {
    const auto count = static_cast<std::int64_t>(order_.size());
    if (count == 0 || (!options_.pingpong && position_ >= count)) return false;
    const std::int64_t k = position_++;
    const std::int64_t turn = std::max<std::int64_t>(1, 2 * (count - 1));
    const std::int64_t i = order_[static_cast<std::size_t>(k % turn < count ? k % turn : turn - k % turn)];
    const auto at = static_cast<std::size_t>(i);
    pair.index = saturated_sum(options_.first, step(k));
    pair.stamp_ns = options_.pingpong ? next_stamp(k, i) : stamps_.stamps_ns[at];
    pair.truth_T_world_camera.reset();
    pair.right_offset_ns = 0;
    pair.host_ns = 0;
    if (stamps_.skipped[at]) return Error{"stamp is out of order", store_->name(i), stamps_.reason[at]};
    if (auto ok = store_->load(i, pair); !ok) return ok.error();
    if (mosaic_) {
      to_grey_.convert(pair.left.view());
      to_grey_.convert(pair.right.view());
    }
    return true;
  }
  std::int64_t warned() const { return store_->warned() - warned_before_; }

 private:
  std::int64_t step(std::int64_t k) const {
    std::int64_t product = 0;
    return __builtin_mul_overflow(k, options_.pingpong ? every_ : options_.every, &product) ? INT64_MAX : product;
  }

  // To and fro, the stamps go on by the recorded steps.
  TimestampNs next_stamp(std::int64_t k, std::int64_t i) {
    constexpr std::int64_t kLongestStep = 1'000'000'000'000'000;  // eleven days: a damaged recording may hold anything
    const TimestampNs recorded_ns = stamps_.stamps_ns[static_cast<std::size_t>(i)];
    if (k == 0) {
      stamp_ns_ = recorded_ns;
    } else {
      const std::int64_t step_ns = saturated_distance(recorded_ns, last_recorded_ns_);
      stamp_ns_ = saturated_sum(stamp_ns_, order_.size() == 1 ? period_ns_ : std::min(kLongestStep, step_ns));
    }
    last_recorded_ns_ = recorded_ns;
    return stamp_ns_;
  }

  std::unique_ptr<PairStore> store_;
  RisingStamps stamps_;
  RecordingOptions options_;
  bool mosaic_;
  MosaicToGrey to_grey_;
  std::int64_t warned_before_;
  std::vector<std::int64_t> order_;       // of the pairs that are played
  std::int64_t period_ns_ = 100'000'000;  // a single pair over and over
  std::int64_t every_ = 1;
  std::int64_t position_ = 0;
  TimestampNs stamp_ns_ = 0;
  TimestampNs last_recorded_ns_ = 0;
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
  std::string status() const override {
    const std::int64_t warned = warned_.load(std::memory_order_relaxed);
    return warned == 0 ? std::string() : fmt::format("{} images with flaws that cost no pixel", warned);
  }

  Result<bool> next(StereoPair& pair) override {
    if (!thread_.joinable()) return read(pair);
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait(lock, [this] { return filled_ > 0 || ended_; });
    if (filled_ == 0) return false;
    Slot& slot = slots_[taken_ % slots_.size()];
    // The storage is swapped both ways: nothing is copied, nothing allocated.
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

  Result<bool> read(StereoPair& pair) {
    Result<bool> result = reader_.next(pair);
    warned_.store(reader_.warned(), std::memory_order_relaxed);
    return result;
  }

  void fill() {
    for (std::size_t k = 0;; ++k) {
      Slot& slot = slots_[k % slots_.size()];
      {
        std::unique_lock<std::mutex> lock(mutex_);
        changed_.wait(lock, [this] { return stop_ || filled_ < slots_.size(); });
        if (stop_) return;
      }
      slot.result = guarded("reading ahead", [&] { return read(slot.pair); });
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
  std::atomic<std::int64_t> warned_{0};
  std::thread thread_;
};

// Of a store whose first images are the right camera's.
class ExchangedPairs final : public PairStore {
 public:
  explicit ExchangedPairs(std::unique_ptr<PairStore> store) : store_(std::move(store)) {}
  std::int64_t size() const override { return store_->size(); }
  std::string name(std::int64_t i) const override { return store_->name(i); }
  Result<void> load(std::int64_t i, StereoPair& pair) override {
    if (auto ok = store_->load(i, pair); !ok) return ok;
    std::swap(pair.left, pair.right);
    return {};
  }
  std::int64_t warned() const override { return store_->warned(); }

 private:
  std::unique_ptr<PairStore> store_;
};

// Numbered streams ("cam0", "cam1") follow the cameras of the calibration; those with left and right in their names say
// themselves what they are, as does the user.
bool follow_exchanged_cameras(const StreamNames& streams, const RecordingOptions& options) {
  if (options.order_stated) return false;
  const std::optional<int> kind = pair_kind(streams.first, streams.second);
  return kind && *kind >= kFirstNumberKind && *kind < kFirstOtherKind;
}

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

}  // namespace

Result<std::vector<std::int64_t>> choose_pairs(std::int64_t count, const RecordingOptions& o) {
  if (auto ok = check_options(o); !ok) return ok.error();
  for (const auto& [which, i] : {std::pair{"first", o.first}, std::pair{"last", o.last}}) {
    if (i < count) continue;
    return Error{fmt::format("{} pair is behind the end", which), o.path,
                 fmt::format("the recording has pairs 0 to {}", count - 1)};
  }
  const std::int64_t last = o.last < 0 ? count - 1 : o.last;
  std::vector<std::int64_t> chosen;
  for (std::int64_t i = o.first; i <= last; i = saturated_sum(i, o.every)) chosen.push_back(i);
  return chosen;
}

Result<StereoCalibration> calibrate(const CalibrationRequest& request, PairStore& store) {
  std::vector<StereoPair> pairs;
  const std::int64_t last = store.size() - 1;
  for (const std::int64_t i : std::set<std::int64_t>{0, last / 2, last}) {
    StereoPair pair;
    if (i < 0 || !store.load(i, pair)) continue;  // next()'s to report
    if (pair.left.width() == request.width && pair.left.height() == request.height &&
        pair.right.width() == request.width && pair.right.height() == request.height) {
      pairs.push_back(std::move(pair));
    }
  }
  std::vector<ImagePairView> views;
  views.reserve(pairs.size());
  for (const StereoPair& pair : pairs) views.push_back({pair.left.cview(), pair.right.cview()});
  return read_calibration_for(request, views);
}

double rate_of(const RisingStamps& stamps) {
  // Of all pairs, the skipped ones too: what they leave out is no period.
  std::vector<TimestampNs> rising;
  for (const TimestampNs stamp_ns : stamps.stamps_ns) {
    if (rising.empty() || stamp_ns > rising.back()) rising.push_back(stamp_ns);
  }
  const std::int64_t period_ns = median_period_ns(rising);
  return period_ns > 0 ? 1e9 / static_cast<double>(period_ns) : 0.0;
}

std::unique_ptr<FrameSource> play_pairs(std::unique_ptr<PairStore> store, const StreamNames& streams,
                                        RisingStamps stamps, SourceInfo info, const RecordingOptions& options) {
  if (info.calibration.exchanged && follow_exchanged_cameras(streams, options)) {
    store = std::make_unique<ExchangedPairs>(std::move(store));
    info.calibration.notes.push_back("so are its images: the recording numbers its cameras likewise");
  }
  if (info.rate_hz > kMostRate_hz && !options.rate_hz) {
    info.description +=
        fmt::format(", {:.0f} Hz by its times, which no camera has: --rate HZ gives it another", info.rate_hz);
  }
  const MosaicSurvey survey = survey_mosaic(*store, options.bayer);
  if (survey.mosaic) info.description += ", " + survey.text;
  PairReader reader(std::move(store), std::move(stamps), options, survey.mosaic);
  return std::make_unique<Recording>(std::move(info), std::move(reader), options.read_ahead);
}

}  // namespace cliquevo::drivers
