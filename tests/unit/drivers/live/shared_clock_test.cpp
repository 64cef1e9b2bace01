// SPDX-License-Identifier: BSD-3-Clause
// Pairing by stamp, where both cameras are on one clock.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/live/pair_sync.h"
#include "tests/unit/drivers/live/tally.h"

namespace cliquevo::drivers {
namespace {

using test::at_30_hz;
using test::check_counts;
using test::run;
using test::Tally;
using test::TormentFrame;
using test::TormentOptions;

TEST(pair_sync, cameras_on_one_clock_that_expose_apart_are_reported_not_paired) {
  TormentOptions torment;
  torment.exposures = 500;
  torment.arrival_jitter = 0.02;
  torment.drop = torment.twice = torment.reorder = 0.0;
  torment.drift_ppm = 0.0;
  torment.offset_s = 0.0;
  torment.phase = 0.4;
  PairSyncOptions options = at_30_hz();
  options.shared_clock = true;
  PairSync sync(options);
  EXPECT_EQ(run(torment, sync).pairs, 0);
  EXPECT_EQ(sync.state(), SyncState::out_of_phase);
  torment.phase = 0.02;
  PairSync near(options);
  EXPECT_GE(run(torment, near).pairs, 460);
  EXPECT_EQ(near.state(), SyncState::synchronised);
}

TEST(pair_sync, clock_called_shared_that_is_not_pairs_nothing) {
  TormentOptions torment;
  torment.exposures = 500;
  torment.arrival_jitter = 0.02;
  torment.drift_ppm = 0.0;
  torment.offset_s = 3.0 / 30.0;
  PairSyncOptions options = at_30_hz();
  options.shared_clock = true;
  PairSync sync(options);
  EXPECT_EQ(run(torment, sync).pairs, 0);
  EXPECT_EQ(sync.state(), SyncState::out_of_phase);
}

TEST(pair_sync, on_a_shared_clock_the_first_frames_are_paired_already) {
  TormentOptions torment;
  torment.exposures = 500;
  torment.arrival_jitter = 0.05;
  torment.stamp_jitter = 0.0;
  torment.drop = torment.twice = torment.reorder = 0.0;
  torment.drift_ppm = 0.0;
  torment.offset_s = 0.0;
  PairSyncOptions options = at_30_hz();
  options.shared_clock = true;
  PairSync sync(options);
  const Tally tally = run(torment, sync);
  EXPECT_EQ(tally.pairs, 500);
  EXPECT_EQ(tally.false_pairs, 0);
}

TEST(pair_sync, torment_on_a_shared_clock_gives_no_false_pair) {
  Tally all;
  for (std::uint64_t seed = 11; seed <= 14; ++seed) {
    TormentOptions torment;
    torment.seed = seed;
    torment.exposures = 50'000;
    torment.drift_ppm = 0.0;
    torment.offset_s = seed == 14 ? 1.0 / 30.0 : 0.0;  // the last one is shared by name alone
    torment.step_every = seed == 13 ? 2000 : 0;
    PairSyncOptions options = at_30_hz();
    options.shared_clock = true;
    PairSync sync(options);
    const Tally tally = run(torment, sync);
    EXPECT_EQ(tally.false_pairs, 0) << "seed " << seed;
    all.pairs += seed < 13 ? tally.pairs : 0;
  }
  EXPECT_GE(static_cast<double>(all.pairs), 0.97 * 0.98 * 0.98 * 100'000);
}

// A host that stalls, for one camera or for both, and stamps what has come meanwhile when it goes on; some frames
// are lost on the wire, where the driver's count does not see them.
std::vector<TormentFrame> stamped_by_a_stalling_host(std::uint64_t seed, std::int64_t exposures, double period_ns) {
  std::mt19937_64 random(seed);
  const auto even = [&](double from, double to) {
    return from + (to - from) * static_cast<double>(random() >> 11U) * 0x1p-53;
  };
  std::vector<TormentFrame> frames;
  double busy_until_ns[2] = {0.0, 0.0};
  std::int64_t sequence[2] = {0, 0};
  for (std::int64_t k = 0; k < exposures; ++k) {
    const double t_ns = static_cast<double>(k + 1) * period_ns;
    const bool both = even(0, 1) < 0.01;
    const double long_ns = even(0.2, 4.0) * period_ns;
    for (const std::size_t camera : {std::size_t{0}, std::size_t{1}}) {
      if (both || even(0, 1) < 0.02) busy_until_ns[camera] = t_ns + (both ? long_ns : even(0.2, 4.0) * period_ns);
      if (even(0, 1) < 0.005) continue;
      TormentFrame f;
      f.camera = camera == 0 ? CameraSide::left : CameraSide::right;
      f.exposure_ns = std::llround(t_ns);
      f.frame.arrival_ns = std::llround(std::max(t_ns + 1e6, busy_until_ns[camera]) + even(0.0, 1e6));
      busy_until_ns[camera] = std::max(busy_until_ns[camera], static_cast<double>(f.frame.arrival_ns));
      f.frame.stamp_ns = f.frame.arrival_ns;
      f.frame.token = static_cast<std::uint32_t>(k);
      f.frame.sequence = sequence[camera]++;
      frames.push_back(f);
    }
  }
  std::stable_sort(frames.begin(), frames.end(), [](const TormentFrame& a, const TormentFrame& b) {
    return a.frame.arrival_ns < b.frame.arrival_ns;
  });
  return frames;
}

TEST(pair_sync, stamps_made_by_a_stalling_host_give_no_false_pair) {
  std::int64_t pairs = 0;
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    PairSyncOptions options = at_30_hz();
    options.shared_clock = options.stamped_on_arrival = true;
    PairSync sync(options);
    SyncOutcome outcome;
    Tally tally;
    for (const TormentFrame& f : stamped_by_a_stalling_host(seed, 20'000, 1e9 / 30.0)) {
      sync.push(f.camera, f.frame, outcome);
      for (const SyncPair& pair : outcome.pairs) ASSERT_EQ(pair.left, pair.right) << "seed " << seed;
      pairs += static_cast<std::int64_t>(outcome.pairs.size());
      outcome.clear();
      check_counts(sync, tally);
    }
    EXPECT_EQ(tally.miscounted, 0);
  }
  EXPECT_GE(pairs, 200'000 / 2);  // a stall costs some frames behind it
}

TEST(pair_sync, on_a_shared_clock_a_stall_costs_its_own_frames_alone) {
  PairSyncOptions options = at_30_hz();
  options.shared_clock = true;
  PairSync sync(options);
  SyncOutcome outcome;
  std::mt19937_64 random(7);
  std::int64_t pairs = 0;
  std::int64_t t_ns = 0;
  constexpr std::int64_t kPeriodNs = 33'333'333;
  for (std::uint32_t k = 0; k < 3000; ++k) {
    t_ns += kPeriodNs + static_cast<std::int64_t>(random() % 20'000'000);  // triggered, but at no steady pace
    sync.push(CameraSide::left, {t_ns, t_ns + 1'000'000, k, k}, outcome);
    const std::int64_t late_ns = k % 50 == 0 ? kPeriodNs / 2 : 0;
    sync.push(CameraSide::right, {t_ns, t_ns + 1'000'000 + late_ns, k, k}, outcome);
    for (const SyncPair& pair : outcome.pairs) ASSERT_EQ(pair.left, pair.right);
    pairs += static_cast<std::int64_t>(outcome.pairs.size());
    outcome.clear();
  }
  EXPECT_GE(pairs, 3000 * 94 / 100);
}

}  // namespace
}  // namespace cliquevo::drivers
