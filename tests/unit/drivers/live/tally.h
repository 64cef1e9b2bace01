// SPDX-License-Identifier: BSD-3-Clause
// Runs frames through PairSync and counts what must never be.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/live/pair_sync.h"
#include "tests/unit/drivers/live/torment.h"

namespace cliquevo::test {

struct Tally {
  std::int64_t frames = 0;
  std::int64_t pairs = 0;
  std::int64_t false_pairs = 0;   // of different exposures
  std::int64_t disordered = 0;    // not behind the pair before
  std::int64_t miscounted = 0;    // frames that are in none of the counts
  double most_apart_periods = 0;  // of the exposures of a pair
};

inline void check_counts(const drivers::PairSync& sync, Tally& tally) {
  for (const drivers::CameraSide camera : {drivers::CameraSide::left, drivers::CameraSide::right}) {
    const drivers::SyncCounts& c = sync.counts(camera);
    if (c.received != c.paired + c.unpaired + c.late + c.doubled + c.uncertain + sync.waiting(camera))
      ++tally.miscounted;
  }
}

inline Tally run(const TormentOptions& options, drivers::PairSync& sync) {
  const std::vector<TormentFrame> frames = make_torment(options);
  std::vector<std::int64_t> exposures[2];
  for (auto& e : exposures) e.resize(static_cast<std::size_t>(options.exposures));
  Tally tally;
  drivers::SyncOutcome outcome;
  std::int64_t last = -1;
  std::int64_t handed_back = 0;
  for (const TormentFrame& f : frames) {
    exposures[static_cast<std::size_t>(f.camera)][f.frame.token] = f.exposure_ns;
    sync.push(f.camera, f.frame, outcome);
    for (const drivers::SyncPair& pair : outcome.pairs) {
      ++tally.pairs;
      if (pair.left != pair.right) ++tally.false_pairs;
      if (pair.left <= last) ++tally.disordered;
      last = pair.left;
      const double apart = static_cast<double>(exposures[1][pair.right] - exposures[0][pair.left]);
      tally.most_apart_periods = std::max(tally.most_apart_periods, std::abs(apart) * options.rate_hz * 1e-9);
    }
    handed_back += static_cast<std::int64_t>(outcome.released.size() + 2 * outcome.pairs.size());
    outcome.clear();
    check_counts(sync, tally);
  }
  tally.frames = static_cast<std::int64_t>(frames.size());
  // Every token comes back once, but for those that still wait.
  EXPECT_EQ(handed_back + sync.waiting(drivers::CameraSide::left) + sync.waiting(drivers::CameraSide::right),
            tally.frames);
  EXPECT_EQ(tally.miscounted, 0);
  EXPECT_EQ(tally.disordered, 0);
  return tally;
}

inline drivers::PairSyncOptions at_30_hz() {
  drivers::PairSyncOptions options;
  options.rate_hz = 30.0;
  return options;
}

}  // namespace cliquevo::test
