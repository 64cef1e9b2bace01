// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/pair_store.h"

#include <array>
#include <condition_variable>
#include <cstdlib>
#include <mutex>
#include <set>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "drivers/calibration/examine.h"
#include "drivers/recording/pairing.h"

namespace cliquevo::drivers {

namespace {

// Reads pair after pair from the disk; one thread at a time.
class PairReader {
 public:
  PairReader(std::unique_ptr<PairStore> store, const RecordingOptions& options)
      : store_(std::move(store)), options_(options) {
    std::vector<TimestampNs> stamps;
    for (std::int64_t i = 0; i < store_->size(); ++i) stamps.push_back(store_->stamp_ns(i));
    period_ns_ = median_period_ns(stamps);
    if (period_ns_ <= 0) period_ns_ = 100'000'000;  // a single pair over and over
  }

  Result<bool> next(StereoPair& pair) {
    const std::int64_t count = store_->size();
    if (!options_.pingpong && position_ >= count) return false;
    const std::int64_t k = position_++;
    const std::int64_t turn = std::max<std::int64_t>(1, 2 * (count - 1));
    const std::int64_t i = k % turn < count ? k % turn : turn - k % turn;
    const TimestampNs recorded_ns = store_->stamp_ns(i);
    if (k == 0) {
      stamp_ns_ = recorded_ns;
    } else {
      stamp_ns_ += count == 1 ? period_ns_ : std::abs(recorded_ns - last_recorded_ns_);
    }
    last_recorded_ns_ = recorded_ns;
    pair.index = options_.first + k * options_.every;
    pair.stamp_ns = stamp_ns_;
    pair.truth_T_world_camera.reset();
    pair.right_offset_ns = 0;
    pair.host_ns = 0;
    if (auto ok = store_->load(i, pair); !ok) return ok.error();
    return true;
  }

 private:
  std::unique_ptr<PairStore> store_;
  RecordingOptions options_;
  std::int64_t period_ns_ = 0;
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
  for (std::int64_t i = o.first; i <= last; i += o.every) chosen.push_back(i);
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
  for (const StereoPair& pair : pairs) views.push_back({pair.left.cview(), pair.right.cview()});
  return read_calibration_for(request, views);
}

std::unique_ptr<FrameSource> play_pairs(std::unique_ptr<PairStore> store, SourceInfo info,
                                        const RecordingOptions& options) {
  return std::make_unique<Recording>(std::move(info), PairReader(std::move(store), options), options.read_ahead);
}

}  // namespace cliquevo::drivers
