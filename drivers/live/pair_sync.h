// SPDX-License-Identifier: BSD-3-Clause
// Makes pairs of the frames of two live cameras: by exposure time, never by order of arrival. The offset and drift
// between their clocks are estimated. A pair is given as soon as it is certain; every frame is paired or counted.
#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "drivers/live/numbered_grid.h"
#include "drivers/live/shared_clock.h"
#include "drivers/live/sync_types.h"

namespace cliquevo::drivers {

class PairSync {
 public:
  explicit PairSync(const PairSyncOptions& options);

  // A frame arrived. Appends to `outcome`; tokens in it are the caller's again.
  void push(CameraSide camera, const SyncFrame& frame, SyncOutcome& outcome);
  // Time has passed without frames: detects lost cameras, hands back what waits for them.
  void advance(std::int64_t now_ns, SyncOutcome& outcome);

  SyncState state() const;
  const SyncCounts& counts(CameraSide camera) const { return books_.counts(camera); }
  std::int64_t waiting(CameraSide camera) const {
    return static_cast<std::int64_t>(grid_.waiting(camera).size() + shared_clock_.waiting(camera));
  }
  // Right stamp - left stamp of one exposure, ns; nothing before the clocks are known.
  std::optional<std::int64_t> clock_offset_ns() const { return grid_.clock_offset_ns(); }
  // Rate of the right clock against the left, parts per million; nothing before it is known to a few (1000 pairs).
  std::optional<double> clock_drift_ppm() const { return grid_.clock_drift_ppm(); }

 private:
  struct Side {
    std::int64_t last_arrival_ns = 0;
    bool lost = false;
    TimestampNs last_stamp_ns = 0;  // of any frame, as is its number
    std::int64_t last_sequence = 0;
    int regular = -1;  // frames in a row whose stamp and sequence agree; -1: none at all yet
  };

  Side& side(CameraSide camera) { return sides_[static_cast<std::size_t>(camera)]; }
  const Side& side(CameraSide camera) const { return sides_[static_cast<std::size_t>(camera)]; }
  bool is_regular(Side& s, const SyncFrame& frame) const;
  void expire(CameraSide camera);
  void find_lost(std::int64_t now_ns);
  void file(CameraSide camera, const SyncFrame& frame);

  PairSyncOptions options_;
  double period_ns_;
  NumberedGrid grid_;
  SharedClock shared_clock_;
  SyncBooks books_;
  std::array<Side, 2> sides_;
  bool begun_ = false;
};

}  // namespace cliquevo::drivers
