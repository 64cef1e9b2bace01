// SPDX-License-Identifier: BSD-3-Clause
// The parts of pairing, each by itself: the books, the rate, the grid of numbers; and what cameras must be given.
#include <memory>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "drivers/live/camera_options.h"
#include "drivers/live/live_pairs.h"
#include "drivers/live/numbered_grid.h"
#include "drivers/live/pairs_source.h"
#include "drivers/live/shared_clock.h"
#include "drivers/live/sync_books.h"

namespace cliquevo::drivers {
namespace {

constexpr std::int64_t kPeriod_ns = 33'333'333;

TEST(SyncBooks, EveryFrameIsCountedWhereItWent) {
  SyncBooks books;
  SyncOutcome outcome;
  books.begin(outcome);
  WaitingFrame left, right;
  left.token = 3, left.stamp_ns = 1000;
  right.token = 4, right.stamp_ns = 1010;
  EXPECT_TRUE(books.is_after_last(-5)) << "nothing went out yet";
  books.pair(left, right, 10);
  EXPECT_FALSE(books.is_after_last(1000));
  EXPECT_TRUE(books.is_after_last(1001));
  for (const SyncLoss why : {SyncLoss::unpaired, SyncLoss::late, SyncLoss::doubled, SyncLoss::uncertain}) {
    books.release(CameraSide::right, right, why);
  }
  ASSERT_EQ(outcome.pairs.size(), 1U);
  EXPECT_EQ(outcome.pairs[0].left, 3U);
  EXPECT_EQ(outcome.pairs[0].right, 4U);
  EXPECT_EQ(outcome.pairs[0].stamp_ns, 1000);
  EXPECT_EQ(outcome.pairs[0].skew_ns, 10);
  EXPECT_EQ(outcome.released.size(), 4U);
  EXPECT_EQ(books.counts(CameraSide::left).paired, 1);
  EXPECT_EQ(books.counts(CameraSide::left).unpaired, 0);
  const SyncCounts& c = books.counts(CameraSide::right);
  EXPECT_EQ(c.paired + c.unpaired + c.late + c.doubled + c.uncertain, 5);
}

TEST(CameraRate, LostFramesDoNotCount) {
  CameraRate rate;
  EXPECT_EQ(rate.hz(), 0.0);
  TimestampNs stamp = 5'000'000'000;
  for (int i = 0; i < 60; ++i) {
    stamp += i % 5 == 0 ? 3 * kPeriod_ns : kPeriod_ns;
    rate.add(stamp);
  }
  EXPECT_NEAR(rate.hz(), 30.0, 0.01);
}

// Frames of two triggered cameras whose clocks differ, as they arrive.
TEST(NumberedGrid, PairsExposuresOfClocksThatDifferAndFindsTheirOffset) {
  PairSyncOptions options;
  options.rate_hz = 30.0;
  NumberedGrid grid(options);
  SyncBooks books;
  SyncOutcome outcome;
  books.begin(outcome);
  constexpr std::int64_t kOffset_ns = 987'654'321'000;
  for (std::uint32_t i = 0; i < 200; ++i) {
    for (const CameraSide camera : {CameraSide::left, CameraSide::right}) {
      SyncFrame frame;
      frame.stamp_ns = i * kPeriod_ns + (camera == CameraSide::right ? kOffset_ns : 0);
      frame.arrival_ns = 7'000'000'000 + i * kPeriod_ns + (camera == CameraSide::right ? 400'000 : 0);
      frame.token = i;
      const CameraClock::Reading reading = grid.read(camera, frame, books);
      if (reading.verdict == CameraClock::Verdict::uncertain) continue;
      EXPECT_NE(reading.verdict, CameraClock::Verdict::doubled);
      WaitingFrame waiting;
      waiting.index = reading.index;
      waiting.stamp_ns = frame.stamp_ns;
      waiting.token = frame.token;
      waiting.certain = reading.verdict == CameraClock::Verdict::certain;
      waiting.arrival_ns = frame.arrival_ns;
      if (reading.confirms) grid.confirm(camera);
      grid.wait(camera, waiting, books);
      grid.pair_up(books);
    }
  }
  EXPECT_TRUE(grid.locked());
  EXPECT_TRUE(grid.related());
  EXPECT_FALSE(grid.out_of_phase());
  EXPECT_GT(outcome.pairs.size(), 100U);
  for (const SyncPair& pair : outcome.pairs) EXPECT_EQ(pair.left, pair.right);
  ASSERT_TRUE(grid.clock_offset_ns().has_value());
  EXPECT_NEAR(static_cast<double>(*grid.clock_offset_ns()), static_cast<double>(kOffset_ns), 1e6);
  grid.release_all(CameraSide::left, SyncLoss::uncertain, books);
  EXPECT_TRUE(grid.waiting(CameraSide::left).empty());
}

TEST(SharedClock, FramesOfOneStampArePairedWithoutNumbers) {
  PairSyncOptions options;
  options.rate_hz = 30.0;
  options.shared_clock = true;
  SharedClock clock(options);
  NumberedGrid grid(options);
  SyncBooks books;
  SyncOutcome outcome;
  books.begin(outcome);
  WaitingFrame frame;
  frame.numbered = false;
  for (int i = 0; i < 5; ++i) {
    frame.stamp_ns = i * kPeriod_ns;
    frame.arrival_ns = 100'000'000 + i * kPeriod_ns;
    frame.token = static_cast<std::uint32_t>(i);
    EXPECT_FALSE(clock.pair(CameraSide::left, frame, grid, books));
    clock.keep(CameraSide::left, frame, books);
    frame.arrival_ns += 1'000'000;
    EXPECT_TRUE(clock.pair(CameraSide::right, frame, grid, books)) << i;
  }
  EXPECT_EQ(outcome.pairs.size(), 5U);
  frame.stamp_ns = 100 * kPeriod_ns;
  clock.keep(CameraSide::right, frame, books);
  EXPECT_EQ(clock.waiting(CameraSide::right), 1U);
  clock.release_all(books);
  EXPECT_EQ(clock.waiting(CameraSide::right), 0U);
  EXPECT_FALSE(outcome.released.empty());
}

TEST(LivePairs, OneCameraForBothImagesNeedsNoPairing) {
  PairSyncOptions options;
  options.rate_hz = 30.0;
  LivePairs pairs(options, 4, 3);
  Image<std::uint8_t> left(4, 3), right(4, 3), small(2, 2);
  left.fill(10);
  right.fill(20);
  LiveFrame frame;
  frame.stamp_ns = 1'700'000'000'000'000'000;
  frame.arrival_utc_ns = frame.stamp_ns + 3'000'000;
  LiveFrame l = frame, r = frame;
  l.image = left.cview();
  r.image = right.cview();
  pairs.push_pair(l, r);
  StereoPair pair;
  ASSERT_TRUE(pairs.next(pair));
  EXPECT_EQ(pair.left.cview()(0, 0), 10);
  EXPECT_EQ(pair.right.cview()(3, 2), 20);
  EXPECT_EQ(pair.stamp_ns, frame.stamp_ns);
  pairs.count_incomplete(CameraSide::right);
  EXPECT_EQ(pairs.incomplete(CameraSide::right), 1);
  pairs.interrupt();
  EXPECT_FALSE(pairs.next(pair));
}

// A family's pairs that are nothing but a count.
struct MadePairs {
  int left = 2;
  bool stopped = false;
  bool next(StereoPair& pair) {
    pair.index = left;
    return !stopped && left-- > 0;
  }
  void interrupt() { stopped = true; }
  std::string status() const { return "left camera: reconnecting"; }
  std::string queues() const { return "1 waits"; }
};

TEST(PairsSource, HandsEverythingOn) {
  SourceInfo info;
  info.width = 4;
  PairsSource<MadePairs> source(std::move(info), std::make_unique<MadePairs>());
  EXPECT_EQ(source.info().width, 4);
  EXPECT_EQ(source.status(), "left camera: reconnecting");
  EXPECT_EQ(source.queues(), "1 waits");
  StereoPair pair;
  EXPECT_TRUE(*source.next(pair));
  EXPECT_EQ(pair.index, 2);
  source.interrupt();
  EXPECT_FALSE(*source.next(pair));
}

CameraOptions whole() {
  CameraOptions o;
  o.left = "A";
  o.right = "B";
  o.calibration = "rig.yaml";
  return o;
}

TEST(CameraOptions, NameTwoDifferentCamerasAndACalibration) {
  EXPECT_TRUE(whole().check_names().ok());
  const auto missing = [](void (*spoil)(CameraOptions&)) {
    CameraOptions o = whole();
    spoil(o);
    const auto named = o.check_names();
    return named.ok() ? std::string() : named.error().where;
  };
  EXPECT_EQ(missing([](CameraOptions& o) { o.left.clear(); }), "left");
  EXPECT_EQ(missing([](CameraOptions& o) { o.right.clear(); }), "right");
  EXPECT_EQ(missing([](CameraOptions& o) { o.right = o.left; }), "right");
  EXPECT_EQ(missing([](CameraOptions& o) { o.calibration.clear(); }), "calibration");
  EXPECT_EQ(missing([](CameraOptions& o) { o.layout = CameraLayout::side_by_side, o.right.clear(); }), "")
      << "one camera for both images";
}

TEST(CameraOptions, ValuesOutOfRangeAreNamed) {
  EXPECT_TRUE(whole().check().ok());
  const std::pair<const char*, void (*)(CameraOptions&)> cases[] = {
      {"rate_hz", [](CameraOptions& o) { o.rate_hz = 0.0; }},
      {"width", [](CameraOptions& o) { o.width = -1; }},
      {"binning", [](CameraOptions& o) { o.binning = 0; }},
      {"exposure_us", [](CameraOptions& o) { o.exposure_us = 0.0; }},
      {"exposure_max_us", [](CameraOptions& o) { o.exposure_max_us = -1.0; }},
      {"packet_size", [](CameraOptions& o) { o.packet_size = 70000; }},
  };
  for (const auto& [key, spoil] : cases) {
    CameraOptions o = whole();
    spoil(o);
    const auto ok = o.check();
    ASSERT_FALSE(ok.ok()) << key;
    EXPECT_EQ(ok.error().where, key);
  }
}

}  // namespace
}  // namespace cliquevo::drivers
