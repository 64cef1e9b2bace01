// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/live/sync_books.h"

namespace cliquevo::drivers {

void SyncBooks::release(CameraSide camera, const WaitingFrame& frame, SyncLoss why) {
  SyncCounts& counts = this->counts(camera);
  switch (why) {
    case SyncLoss::unpaired:
      ++counts.unpaired;
      break;
    case SyncLoss::late:
      ++counts.late;
      break;
    case SyncLoss::doubled:
      ++counts.doubled;
      break;
    case SyncLoss::uncertain:
      ++counts.uncertain;
      break;
  }
  outcome_->released.push_back({camera, frame.token, why});
}

void SyncBooks::pair(const WaitingFrame& left, const WaitingFrame& right, std::int64_t skew_ns) {
  outcome_->pairs.push_back({left.token, right.token, left.stamp_ns, skew_ns});
  for (SyncCounts& counts : counts_) ++counts.paired;
  last_stamp_ns_ = left.stamp_ns;
}

}  // namespace cliquevo::drivers
