// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/live/sync_types.h"

namespace cliquevo::drivers {

Result<void> PairSyncOptions::check() const {
  if (!(rate_hz >= 0.01 && rate_hz <= 10000.0)) {
    return Error{"frame rate is out of 0.01 to 10000 Hz", "pair synchronisation", "give the rate of the cameras"};
  }
  if (!(tolerance > 0.0 && tolerance <= 0.3)) {
    return Error{"pair tolerance is out of 0 to 0.3 periods", "pair synchronisation", "give 0.25 or less"};
  }
  if (!(lost_after_s > 0.0 && lost_after_s <= 3600.0)) {
    return Error{"lost_after is out of 0 to 3600 s", "pair synchronisation", "give it in seconds"};
  }
  return {};
}

const char* sync_state_name(SyncState state) {
  switch (state) {
    case SyncState::acquiring:
      return "acquiring";
    case SyncState::synchronised:
      return "synchronised";
    case SyncState::out_of_phase:
      return "out of phase";
    case SyncState::left_lost:
      return "left camera lost";
    case SyncState::right_lost:
      return "right camera lost";
    case SyncState::both_lost:
      return "both cameras lost";
  }
  return "unknown";
}

}  // namespace cliquevo::drivers
