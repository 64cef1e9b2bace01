// SPDX-License-Identifier: BSD-3-Clause
// Pairs by stamp, where both cameras stamp by one clock: frames that arrive together need no number, so the first ones
// are paired already. Whether the clock is shared indeed is judged from the arrivals.
#pragma once

#include <array>
#include <vector>

#include "drivers/live/numbered_grid.h"
#include "drivers/live/sync_books.h"

namespace cliquevo::drivers {

class SharedClock {
 public:
  explicit SharedClock(const PairSyncOptions& options);

  // Looks for the partner among what waits here and on the grid. true: the pair has gone out.
  bool pair(CameraSide camera, const WaitingFrame& frame, NumberedGrid& grid, SyncBooks& books);
  // A frame without a number: kept for a partner of the same stamp, or handed back where nothing can come of it.
  void keep(CameraSide camera, const WaitingFrame& frame, SyncBooks& books);
  void release_all(SyncBooks& books);
  std::size_t waiting(CameraSide camera) const { return unnumbered_[static_cast<std::size_t>(camera)].size(); }

 private:
  const WaitingFrame* partner_of(CameraSide camera, const WaitingFrame& frame, const NumberedGrid& grid) const;
  bool trusts(const WaitingFrame& frame, const WaitingFrame& partner);
  void take_out(CameraSide camera, const WaitingFrame& frame, NumberedGrid& grid, SyncBooks& books);

  bool shared_;
  double tolerance_ns_;
  double together_ns_;
  int trust_ = 0;                                        // in stamps alone: below 0 there is none
  std::array<std::vector<WaitingFrame>, 2> unnumbered_;  // in order of arrival, few
};

}  // namespace cliquevo::drivers
