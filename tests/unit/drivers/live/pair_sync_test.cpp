// SPDX-License-Identifier: BSD-3-Clause
// No false pair, whatever the cameras do; and every frame accounted for.
#include "drivers/live/pair_sync.h"

#include <algorithm>
#include <cstdint>
#include <limits>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/drivers/live/tally.h"

namespace cliquevo::drivers {
namespace {

using test::at_30_hz;
using test::check_counts;
using test::make_torment;
using test::run;
using test::Tally;
using test::TormentFrame;
using test::TormentOptions;

TEST(pair_sync, clean_cameras_are_paired_all_but_the_start) {
  TormentOptions torment;
  torment.arrival_jitter = 0.02;
  torment.stamp_jitter = 0.001;
  torment.drop = torment.twice = torment.reorder = 0.0;
  PairSync sync(at_30_hz());
  const Tally tally = run(torment, sync);
  EXPECT_EQ(tally.false_pairs, 0);
  EXPECT_GE(tally.pairs,
            torment.exposures - 30);  // a second to learn the clocks
  EXPECT_EQ(sync.state(), SyncState::synchronised);
}

TEST(pair_sync, on_quiet_cameras_a_pair_goes_out_with_its_second_frame) {
  TormentOptions torment;
  torment.exposures = 1000;
  torment.arrival_jitter = 0.05;
  torment.drop = torment.twice = torment.reorder = 0.0;
  PairSync sync(at_30_hz());
  SyncOutcome outcome;
  int waiting = 0;
  for (const TormentFrame& f : make_torment(torment)) {
    outcome.clear();
    sync.push(f.camera, f.frame, outcome);
    if (f.frame.token < 30) continue;  // the clocks are learnt, and confirmed
    for (const SyncPair& pair : outcome.pairs) EXPECT_EQ(pair.left, f.frame.token);
    waiting = std::max(waiting, static_cast<int>(sync.waiting(CameraSide::left) + sync.waiting(CameraSide::right)));
  }
  EXPECT_EQ(waiting, 1);
}

TEST(pair_sync, torment_of_a_million_frames_gives_no_false_pair) {
  Tally all;
  std::int64_t steps = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    TormentOptions torment;
    torment.seed = seed;
    torment.exposures = 105'000;
    torment.step_every = seed == 5 ? 400 : 2000;
    torment.most_step_periods = seed % 2 == 0 ? 2.5 : 20.0;
    PairSync sync(at_30_hz());
    const Tally tally = run(torment, sync);
    all.frames += tally.frames;
    all.pairs += tally.pairs;
    all.false_pairs += tally.false_pairs;
    steps += torment.exposures / torment.step_every;
    EXPECT_GE(sync.counts(CameraSide::left).clock_steps + sync.counts(CameraSide::right).clock_steps, steps / 10);
  }
  EXPECT_GE(all.frames, 1'000'000);
  EXPECT_EQ(all.false_pairs, 0);
  EXPECT_GE(static_cast<double>(all.pairs),
            0.8 * 0.98 * 0.98 * 525'000);  // and it is of use
}

TEST(pair_sync, without_steps_nearly_every_true_pair_is_found) {
  TormentOptions torment;
  torment.exposures = 50'000;
  PairSync sync(at_30_hz());
  const Tally tally = run(torment, sync);
  EXPECT_EQ(tally.false_pairs, 0);
  EXPECT_GE(static_cast<double>(tally.pairs), 0.99 * 0.98 * 0.98 * 50'000);
  const SyncCounts& left = sync.counts(CameraSide::left);
  EXPECT_NEAR(static_cast<double>(left.missing - left.out_of_order), 0.02 * 50'000, 100);
  EXPECT_NEAR(static_cast<double>(left.doubled), 0.01 * 0.98 * 50'000, 100);
}

TEST(pair_sync, offset_and_drift_are_estimated) {
  for (const double ppm : {-100.0, 0.0, 100.0}) {
    TormentOptions torment;
    torment.exposures = 20'000;
    torment.drift_ppm = ppm;
    torment.offset_s = -3.25;
    PairSync sync(at_30_hz());
    run(torment, sync);
    ASSERT_TRUE(sync.clock_drift_ppm());
    EXPECT_NEAR(*sync.clock_drift_ppm(), ppm, 5.0);
    const double end_s = 20'000 / 30.0;
    ASSERT_TRUE(sync.clock_offset_ns());
    EXPECT_NEAR(static_cast<double>(*sync.clock_offset_ns()) * 1e-9, -3.25 + end_s * ppm * 1e-6, 0.1 / 30.0);
  }
}

TEST(pair_sync, after_a_step_nothing_goes_out_until_certain) {
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    TormentOptions torment;
    torment.seed = seed;
    torment.exposures = 2000;
    torment.step_every = 1500;
    torment.drop = torment.twice = torment.reorder = 0.0;
    torment.most_step_periods = 3.0;
    PairSync sync(at_30_hz());
    SyncOutcome outcome;
    bool learning = false;
    std::int64_t quiet = 0;
    for (const TormentFrame& f : make_torment(torment)) {
      outcome.clear();
      sync.push(f.camera, f.frame, outcome);
      for (const SyncPair& pair : outcome.pairs) ASSERT_EQ(pair.left, pair.right);
      if (f.frame.token < 1500) continue;
      if (sync.state() != SyncState::synchronised) learning = true;
      if (learning && outcome.pairs.empty()) ++quiet;
    }
    // A step of less than the jitter is followed without losing track.
    if (learning) {
      EXPECT_GE(quiet, 24);
    }
    EXPECT_EQ(sync.state(), SyncState::synchronised) << "seed " << seed;
  }
}

TEST(pair_sync, free_running_cameras_pair_by_the_nearest_exposure_within_the_tolerance) {
  TormentOptions torment;
  torment.exposures = 40'000;
  torment.arrival_jitter = 0.1;
  torment.stamp_jitter = 0.01;
  torment.drop = torment.twice = torment.reorder = 0.0;
  torment.drift_ppm = 0.0;
  torment.right_pace_ppm = 100.0;  // slips by four periods on the way
  PairSyncOptions options = at_30_hz();
  options.triggered = false;
  PairSync sync(options);
  const Tally tally = run(torment, sync);
  EXPECT_LE(tally.most_apart_periods, options.tolerance + 0.1);
  // Within a quarter period half of the time, but for what is lost where the partner changes.
  EXPECT_GE(tally.pairs, 18'000);
}

TEST(pair_sync, lost_camera_is_reported_and_comes_back) {
  TormentOptions torment;
  torment.exposures = 1500;
  torment.arrival_jitter = 0.05;
  torment.drop = torment.twice = torment.reorder = 0.0;
  PairSync sync(at_30_hz());
  SyncOutcome outcome;
  std::set<std::uint32_t> paired;
  for (const TormentFrame& f : make_torment(torment)) {
    if (f.camera == CameraSide::right && f.frame.token >= 500 && f.frame.token < 1000) continue;
    outcome.clear();
    sync.push(f.camera, f.frame, outcome);
    for (const SyncPair& pair : outcome.pairs) {
      EXPECT_EQ(pair.left, pair.right);
      paired.insert(pair.left);
    }
    if (f.frame.token == 900) {
      EXPECT_EQ(sync.state(), SyncState::right_lost);
      EXPECT_EQ(sync.waiting(CameraSide::left),
                0);  // nothing is kept for a camera that is gone
    }
  }
  EXPECT_EQ(sync.state(), SyncState::synchronised);
  EXPECT_TRUE(paired.count(490) == 1 && paired.count(700) == 0 && paired.count(1400) == 1);
  outcome.clear();
  sync.advance(std::numeric_limits<std::int64_t>::max() / 2, outcome);
  EXPECT_EQ(sync.state(), SyncState::both_lost);
  EXPECT_STREQ(sync_state_name(sync.state()), "both cameras lost");
}

TEST(pair_sync, camera_that_never_delivers_is_lost) {
  PairSync sync(at_30_hz());
  SyncOutcome outcome;
  for (int k = 0; k < 60; ++k) {
    const std::int64_t t = k * 33'333'333LL;
    sync.push(CameraSide::left, {t, 5'000'000'000 + t, static_cast<std::uint32_t>(k)}, outcome);
  }
  EXPECT_EQ(sync.state(), SyncState::right_lost);
  EXPECT_TRUE(outcome.pairs.empty());
}

TEST(pair_sync, after_the_first_frames_its_lists_do_not_grow) {
  TormentOptions torment;
  torment.exposures = 5000;
  torment.step_every = 700;
  PairSync sync(at_30_hz());
  SyncOutcome outcome;
  std::size_t most = 0;
  for (const TormentFrame& f : make_torment(torment)) {
    outcome.clear();
    sync.push(f.camera, f.frame, outcome);
    most = std::max(most, outcome.released.size() + 2 * outcome.pairs.size());
    ASSERT_LE(sync.waiting(CameraSide::left) + sync.waiting(CameraSide::right), 160);
  }
  EXPECT_LE(most, 200U);
}

TEST(pair_sync, absurd_stamps_are_counted_and_harm_nothing) {
  PairSync sync(at_30_hz());
  SyncOutcome outcome;
  std::uint64_t state = 5;
  Tally tally;
  constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max();
  for (std::uint32_t i = 0; i < 20'000; ++i) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    std::int64_t stamp = static_cast<std::int64_t>(state);
    if (i % 5 == 0) stamp = kMost;
    if (i % 5 == 1) stamp = std::numeric_limits<std::int64_t>::min();
    if (i % 5 == 2) stamp = static_cast<std::int64_t>(state >> 34U);
    sync.push(state >> 63U != 0 ? CameraSide::left : CameraSide::right, {stamp, i * 1'000'000LL, i}, outcome);
    outcome.clear();
    check_counts(sync, tally);
  }
  EXPECT_EQ(tally.miscounted, 0);
}

TEST(pair_sync, options_out_of_bounds_are_named) {
  PairSyncOptions options;
  EXPECT_FALSE(options.check().ok());  // no rate
  options.rate_hz = 30.0;
  EXPECT_TRUE(options.check().ok());
  options.tolerance = 0.5;
  EXPECT_NE(options.check().error().line().find("tolerance"), std::string::npos);
  options.tolerance = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(options.check().ok());
}

}  // namespace
}  // namespace cliquevo::drivers
