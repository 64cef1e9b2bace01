// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/live/live_pairs.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

namespace cliquevo::drivers {

namespace {

constexpr std::uint32_t kMostFrames = 128;  // of a camera: more than the pairing ever holds
constexpr std::size_t kMostReady = 4;
constexpr std::int64_t kUtcWithinNs = 1'000'000'000;  // a clock this near the host's is on UTC itself
constexpr double kClockRise = 1e-3;                   // share of a late arrival by which the offset follows drift
constexpr auto kTick = std::chrono::milliseconds(100);
constexpr std::int64_t kSilentNs = 1'000'000'000;
constexpr double kRateOff = 0.2;  // of the rate that is set: another one

}  // namespace

TimestampNs HostClock::to_utc(TimestampNs stamp_ns, TimestampNs arrival_utc_ns) {
  const std::int64_t offset_ns = arrival_utc_ns - stamp_ns;
  if (!begun_ || std::abs(offset_ns - base_ns_) > 10 * kUtcWithinNs) {
    begun_ = true;
    base_ns_ = offset_ns;
    offset_ns_ = 0.0;
    is_utc_ = std::abs(offset_ns) < kUtcWithinNs;
  }
  if (is_utc_) return stamp_ns;
  const double now = static_cast<double>(offset_ns - base_ns_);
  offset_ns_ = now < offset_ns_ ? now : offset_ns_ + kClockRise * (now - offset_ns_);
  return stamp_ns + base_ns_ + std::llround(offset_ns_);
}

void CameraRate::add(TimestampNs stamp_ns) {
  if (begun_ && stamp_ns > last_ns_) intervals_ns_[count_++ % kIntervals] = stamp_ns - last_ns_;
  begun_ = true;
  last_ns_ = stamp_ns;
}

double CameraRate::hz() const {
  if (count_ < kIntervals) return 0.0;
  auto sorted = intervals_ns_;
  const auto middle = sorted.begin() + kIntervals / 2;
  std::nth_element(sorted.begin(), middle, sorted.end());
  return 1e9 / static_cast<double>(*middle);
}

LivePairs::LivePairs(const PairSyncOptions& options, int width, int height)
    : width_(width), height_(height), sync_(options), rate_hz_(options.rate_hz) {}

bool LivePairs::keep(CameraSide camera, const LiveFrame& frame, std::uint32_t& token) {
  if (!frame.image.same_size(width_, height_)) {
    ++incomplete_[static_cast<std::size_t>(camera)];
    return false;
  }
  Store& s = store(camera);
  if (s.free.empty()) {
    if (s.frames.size() >= kMostFrames) {
      ++overrun_;
      return false;
    }
    s.free.push_back(static_cast<std::uint32_t>(s.frames.size()));
    s.frames.emplace_back();
  }
  token = s.free.back();
  s.free.pop_back();
  s.frames[token].image.copy_from(frame.image);
  s.frames[token].arrival_utc_ns = frame.arrival_utc_ns;
  return true;
}

void LivePairs::give_back(CameraSide camera, std::uint32_t token) { store(camera).free.push_back(token); }

void LivePairs::make_ready(const Ready& pair) {
  if (ready_.size() == kMostReady) {
    give_back(CameraSide::left, ready_.front().left);
    give_back(CameraSide::right, ready_.front().right);
    ready_.pop_front();
    if (index_ > 0) ++overrun_;  // before the first is taken nobody waits for them
  }
  ready_.push_back(pair);
  most_ready_ = std::max(most_ready_, ready_.size());
}

void LivePairs::take_outcome() {
  for (const SyncReleased& released : outcome_.released) give_back(released.camera, released.token);
  for (const SyncPair& pair : outcome_.pairs) {
    make_ready(
        {pair.left, pair.right, pair.stamp_ns, pair.skew_ns, store(CameraSide::left).frames[pair.left].arrival_utc_ns});
  }
  for (const CameraSide camera : {CameraSide::left, CameraSide::right}) {
    std::int64_t& most = most_waiting_[static_cast<std::size_t>(camera)];
    most = std::max(most, sync_.waiting(camera));
  }
  if (!outcome_.pairs.empty()) changed_.notify_all();
  outcome_.clear();
}

void LivePairs::push(CameraSide camera, const LiveFrame& frame) {
  const std::lock_guard<std::mutex> lock(mutex_);
  rates_[static_cast<std::size_t>(camera)].add(frame.stamp_ns);
  std::uint32_t token = 0;
  if (!keep(camera, frame, token)) return;
  sync_.push(camera, {frame.stamp_ns, frame.arrival_mono_ns, token, frame.sequence}, outcome_);
  take_outcome();
}

void LivePairs::push_pair(const LiveFrame& left, const LiveFrame& right) {
  const std::lock_guard<std::mutex> lock(mutex_);
  one_camera_ = true;
  std::uint32_t left_token = 0;
  std::uint32_t right_token = 0;
  if (!keep(CameraSide::left, left, left_token)) return;
  if (!keep(CameraSide::right, right, right_token)) {
    give_back(CameraSide::left, left_token);
    return;
  }
  last_pair_mono_ns_ = left.arrival_mono_ns;
  make_ready({left_token, right_token, left.stamp_ns, 0, left.arrival_utc_ns});
  changed_.notify_all();
}

void LivePairs::count_incomplete(CameraSide camera) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++incomplete_[static_cast<std::size_t>(camera)];
}

void LivePairs::count_flawed(CameraSide camera) {
  const std::lock_guard<std::mutex> lock(mutex_);
  ++flawed_[static_cast<std::size_t>(camera)];
}

void LivePairs::set_state(CameraSide camera, const std::string& text) {
  const std::lock_guard<std::mutex> lock(mutex_);
  states_[static_cast<std::size_t>(camera)] = text;
}

bool LivePairs::next(StereoPair& pair) {
  std::unique_lock<std::mutex> lock(mutex_);
  while (!changed_.wait_for(lock, kTick, [this] { return interrupted_ || !ready_.empty(); })) {
    sync_.advance(monotonic_ns(), outcome_);
    take_outcome();
  }
  if (interrupted_) return false;
  const Ready ready = ready_.front();
  ready_.pop_front();
  pair.index = index_++;
  pair.stamp_ns = std::max(last_stamp_ns_ + 1, clock_.to_utc(ready.stamp_ns, ready.arrival_utc_ns));
  last_stamp_ns_ = pair.stamp_ns;
  pair.right_offset_ns = ready.skew_ns;
  pair.host_ns = ready.arrival_utc_ns;
  pair.truth_T_world_camera.reset();
  // The storage is swapped: nothing is copied.
  std::swap(pair.left, store(CameraSide::left).frames[ready.left].image);
  std::swap(pair.right, store(CameraSide::right).frames[ready.right].image);
  give_back(CameraSide::left, ready.left);
  give_back(CameraSide::right, ready.right);
  return true;
}

void LivePairs::interrupt() {
  const std::lock_guard<std::mutex> lock(mutex_);
  interrupted_ = true;
  changed_.notify_all();
}

std::string LivePairs::status() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::string out;
  for (const std::size_t camera : {std::size_t{0}, std::size_t{1}}) {
    if (!states_[camera].empty()) out += (camera == 0 ? "left camera: " : "right camera: ") + states_[camera] + "; ";
  }
  if (one_camera_) {
    out += monotonic_ns() - last_pair_mono_ns_ > kSilentNs ? "camera silent" : "";
  } else {
    out += sync_state_name(sync_.state());
  }
  const SyncCounts& left = sync_.counts(CameraSide::left);
  const SyncCounts& right = sync_.counts(CameraSide::right);
  const auto add = [&out](const char* name, std::int64_t l, std::int64_t r) {
    if (l + r > 0) out += ", " + std::string(name) + " " + std::to_string(l) + "/" + std::to_string(r);
  };
  add("incomplete", incomplete_[0], incomplete_[1]);
  add("taken with flaws that cost no pixel", flawed_[0], flawed_[1]);
  add("missing", left.missing, right.missing);
  add("unpaired", left.unpaired, right.unpaired);
  add("late", left.late, right.late);
  add("doubled", left.doubled, right.doubled);
  add("uncertain", left.uncertain, right.uncertain);
  const double left_hz = rates_[0].hz();
  const double right_hz = rates_[1].hz();
  const auto off = [this](double hz) { return hz > 0.0 && std::abs(hz - rate_hz_) > kRateOff * rate_hz_; };
  if (off(left_hz) || off(right_hz)) {
    char text[160];
    std::snprintf(text, sizeof text, ", the cameras send %.1f and %.1f Hz where rate_hz is %.1f: give both that rate",
                  left_hz, right_hz, rate_hz_);
    out += text;
  }
  if (overrun_ > 0) out += ", overrun " + std::to_string(overrun_);
  return out;
}

std::string LivePairs::queues() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::string out = "pairs ready up to " + std::to_string(most_ready_) + " of " + std::to_string(kMostReady);
  if (one_camera_) return out;
  return "frames waiting for their partner up to " + std::to_string(most_waiting_[0]) + "/" +
         std::to_string(most_waiting_[1]) + ", " + out;
}

std::int64_t LivePairs::incomplete(CameraSide camera) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return incomplete_[static_cast<std::size_t>(camera)];
}

SyncCounts LivePairs::sync_counts(CameraSide camera) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return sync_.counts(camera);
}

std::int64_t LivePairs::overrun() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return overrun_;
}

}  // namespace cliquevo::drivers
