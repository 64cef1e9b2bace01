// SPDX-License-Identifier: BSD-3-Clause
// Between the threads of two cameras and the one that takes pairs: keeps frames until they are paired, and counts.
#pragma once

#include <array>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <vector>

#include "core/base/image.h"
#include "drivers/frame_source.h"
#include "drivers/live/pair_sync.h"

namespace cliquevo::drivers {

// A camera's stamps to UTC. Stamps that are UTC already (PTP) stay as they are; others get the offset at which the
// quickest frames arrived.
class HostClock {
 public:
  TimestampNs to_utc(TimestampNs stamp_ns, TimestampNs arrival_utc_ns);

 private:
  bool begun_ = false;
  bool is_utc_ = false;
  double offset_ns_ = 0.0;  // to base_ns_
  std::int64_t base_ns_ = 0;
};

// How often a camera exposes, by its own clock: the median of its last intervals, so that lost frames do not
// count.
class CameraRate {
 public:
  void add(TimestampNs stamp_ns);
  double hz() const;  // 0 = not known yet

 private:
  static constexpr std::size_t kIntervals = 31;
  std::array<std::int64_t, kIntervals> intervals_ns_{};
  std::size_t count_ = 0;
  TimestampNs last_ns_ = 0;
  bool begun_ = false;
};

// A frame as its camera's thread has it.
struct LiveFrame {
  ImageView<const std::uint8_t> image;  // grey, 8 bits
  TimestampNs stamp_ns = 0;             // the camera's clock
  std::int64_t arrival_mono_ns = 0;
  TimestampNs arrival_utc_ns = 0;
  std::int64_t sequence = 0;  // the camera's count
};

class LivePairs {
 public:
  LivePairs(const PairSyncOptions& options, int width, int height);

  // The cameras' threads. The image is copied; one of another size is an incomplete frame.
  void push(CameraSide camera, const LiveFrame& frame);
  // One camera for both images: a pair as it stands.
  void push_pair(const LiveFrame& left, const LiveFrame& right);
  void count_incomplete(CameraSide camera);
  // A frame that was taken although its decoder warned.
  void count_flawed(CameraSide camera);
  // What the camera is up to ("reconnecting"); empty = it streams.
  void set_state(CameraSide camera, const std::string& text);

  // The next pair; sleeps until there is one. false: interrupted.
  bool next(StereoPair& pair);
  void interrupt();

  std::string status() const;
  // How deep its queues have been: frames that wait for their partner, and pairs for who takes them.
  std::string queues() const;
  std::int64_t incomplete(CameraSide camera) const;
  SyncCounts sync_counts(CameraSide camera) const;
  std::int64_t overrun() const;

 private:
  struct Ready {
    std::uint32_t left = 0;
    std::uint32_t right = 0;
    TimestampNs stamp_ns = 0;
    std::int64_t skew_ns = 0;
    TimestampNs arrival_utc_ns = 0;
  };
  struct Held {
    Image<std::uint8_t> image;
    TimestampNs arrival_utc_ns = 0;
  };
  struct Store {  // of one camera; a token is an index
    std::vector<Held> frames;
    std::vector<std::uint32_t> free;
  };

  bool keep(CameraSide camera, const LiveFrame& frame, std::uint32_t& token);
  void give_back(CameraSide camera, std::uint32_t token);
  void take_outcome();
  void make_ready(const Ready& pair);
  Store& store(CameraSide camera) { return stores_[static_cast<std::size_t>(camera)]; }

  int width_;
  int height_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  PairSync sync_;
  SyncOutcome outcome_;
  Store stores_[2];
  std::deque<Ready> ready_;
  HostClock clock_;
  double rate_hz_;  // as set
  CameraRate rates_[2];
  std::string states_[2];
  std::int64_t incomplete_[2] = {0, 0};
  std::int64_t flawed_[2] = {0, 0};
  std::int64_t most_waiting_[2] = {0, 0};
  std::size_t most_ready_ = 0;
  std::int64_t overrun_ = 0;  // pairs that nobody took in time
  std::int64_t index_ = 0;
  TimestampNs last_stamp_ns_ = 0;
  bool one_camera_ = false;
  std::int64_t last_pair_mono_ns_ = 0;
  bool interrupted_ = false;
};

}  // namespace cliquevo::drivers
