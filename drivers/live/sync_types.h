// SPDX-License-Identifier: BSD-3-Clause
// What PairSync takes and gives.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/result.h"
#include "core/base/time.h"

namespace cliquevo::drivers {

enum class CameraSide { left, right };
inline CameraSide other(CameraSide camera) { return camera == CameraSide::left ? CameraSide::right : CameraSide::left; }

struct PairSyncOptions {
  double rate_hz = 0.0;   // nominal, of both cameras; must be given
  bool triggered = true;  // both cameras expose at once (one trigger); false: each at its own pace
  // Stamps of both cameras are on one clock (PTP, or mapped to the host's): frames that arrive together need not wait
  // until the clocks are learnt.
  bool shared_clock = false;
  // Stamps are made by this host when a frame arrives: after a stall they are late by any amount. A frame is then taken
  // only behind others whose stamps advance as their sequence numbers do.
  bool stamped_on_arrival = false;
  double tolerance = 0.25;    // periods; largest difference of exposure where they are not triggered, or clock shared
  double lost_after_s = 1.0;  // without a frame a camera counts as lost

  Result<void> check() const;
};

// A frame's exposure on its camera's clock, its arrival on the host's monotonic clock, and what the caller knows it by.
struct SyncFrame {
  TimestampNs stamp_ns = 0;
  std::int64_t arrival_ns = 0;
  std::uint32_t token = 0;
  std::int64_t sequence = 0;  // the camera's count of exposures, as far as it goes; used where stamped on arrival
};

struct SyncPair {
  std::uint32_t left = 0;  // tokens
  std::uint32_t right = 0;
  TimestampNs stamp_ns = 0;  // the left camera's
  std::int64_t skew_ns = 0;  // right exposure - left exposure, on one clock as far as it is known
};

// Why a frame is handed back without a partner.
enum class SyncLoss {
  unpaired,   // its partner did not come
  late,       // a later pair had gone out
  doubled,    // it was here before
  uncertain,  // the clock was not (or no more) known well enough
};

struct SyncReleased {
  CameraSide camera = CameraSide::left;
  std::uint32_t token = 0;
  SyncLoss why = SyncLoss::unpaired;
};

// What a call leads to. The caller keeps one and hands it in again: after the first calls nothing is allocated.
struct SyncOutcome {
  std::vector<SyncPair> pairs;
  std::vector<SyncReleased> released;
  void clear() { pairs.clear(), released.clear(); }
};

// Of one camera. received = paired + unpaired + late + doubled + uncertain + waiting, at any time.
struct SyncCounts {
  std::int64_t received = 0;
  std::int64_t paired = 0;
  std::int64_t unpaired = 0;
  std::int64_t late = 0;
  std::int64_t doubled = 0;
  std::int64_t uncertain = 0;
  // Seen on the way; they overlap with the above.
  std::int64_t missing = 0;       // numbers that did not come
  std::int64_t out_of_order = 0;  // came after a later one
  std::int64_t clock_steps = 0;   // times the clock had to be learnt again
};

enum class SyncState {
  acquiring,     // learning the clocks: nothing goes out
  synchronised,  // pairs go out
  out_of_phase,  // the cameras do not expose together
  left_lost,
  right_lost,
  both_lost,
};
const char* sync_state_name(SyncState state);

}  // namespace cliquevo::drivers
