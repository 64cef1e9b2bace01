// SPDX-License-Identifier: BSD-3-Clause
// The one place where a frame is given out in a pair or handed back, and counted.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "drivers/live/sync_types.h"

namespace cliquevo::drivers {

// A frame that waits for its partner.
struct WaitingFrame {
  std::int64_t index = 0;  // number on its camera's grid
  TimestampNs stamp_ns = 0;
  std::uint32_t token = 0;
  bool certain = false;
  std::int64_t arrival_ns = 0;
  bool numbered = true;  // false: `index` means nothing
};

class SyncBooks {
 public:
  // Where the results of this call go.
  void begin(SyncOutcome& outcome) { outcome_ = &outcome; }

  void release(CameraSide camera, const WaitingFrame& frame, SyncLoss why);
  void pair(const WaitingFrame& left, const WaitingFrame& right, std::int64_t skew_ns);

  SyncCounts& counts(CameraSide camera) { return counts_[static_cast<std::size_t>(camera)]; }
  const SyncCounts& counts(CameraSide camera) const { return counts_[static_cast<std::size_t>(camera)]; }
  // Whether a left stamp is behind that of the last pair.
  bool is_after_last(TimestampNs stamp_ns) const { return !last_stamp_ns_ || stamp_ns > *last_stamp_ns_; }

 private:
  SyncOutcome* outcome_ = nullptr;
  std::array<SyncCounts, 2> counts_;
  std::optional<TimestampNs> last_stamp_ns_;  // left one of the last pair
};

}  // namespace cliquevo::drivers
