// SPDX-License-Identifier: BSD-3-Clause
// GigE Vision cameras over the real protocol: `cliquevo hil` serves them, the driver takes them. Whatever happens, no
// pair may be of two exposures and no image torn.
#include "drivers/aravis.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/aravis/aravis_camera.h"
#include "tests/hil/aravis_rig.h"
#include "tests/support/stall_watch.h"

namespace cliquevo {
namespace {

using drivers::StereoPair;
using hil::camera_options;
using hil::Course;
using hil::open;
using hil::Rig;
using hil::Seen;
using hil::take;
using std::chrono::steady_clock;

// Stamps [us] of the exposures that both cameras sent.
std::set<std::int64_t> sent_by_both(const std::string& log) {
  std::set<std::int64_t> left;
  std::set<std::int64_t> both;
  std::ifstream in(log);
  std::int64_t stamp_us = 0;
  char side = 0;
  int frame = 0;
  std::set<std::int64_t> right;
  while (in >> stamp_us >> side >> frame) (side == 'L' ? left : right).insert(stamp_us);
  std::set_intersection(left.begin(), left.end(), right.begin(), right.end(), std::inserter(both, both.end()));
  return both;
}

struct Judged {
  int exposures = 0;
  int missing = 0;
  std::size_t stalls = 0;
};

// Of the exposures that both cameras sent while `seen` was taken, but for those that were sent while the machine stood
// still or just before or after: a camera would not have waited, and its packets would not have come in a lump.
Judged judge(const Seen& seen, const std::string& log, const std::vector<test::StallWatch::Stall>& stalls,
             std::int64_t period_us) {
  const std::set<std::int64_t> taken(seen.stamps_us.begin(), seen.stamps_us.end());
  const std::set<std::int64_t> sent = sent_by_both(log);
  Judged out;
  out.stalls = stalls.size();
  for (auto s = sent.lower_bound(seen.stamps_us.front()); s != sent.upper_bound(seen.stamps_us.back()); ++s) {
    const bool stalled = std::any_of(stalls.begin(), stalls.end(), [&](const test::StallWatch::Stall& stall) {
      return *s > stall.begin_us - 3 * period_us && *s < stall.end_us + 8 * period_us;
    });
    if (stalled) continue;
    ++out.exposures;
    out.missing += taken.count(*s) == 0 ? 1 : 0;
  }
  return out;
}

// At most one in a thousand may be missing. One in a few hundred is no proof of more than that: then more are taken,
// until a thousand have been judged. Where the machine stands still often, a busy thread is also held up where the
// watch, which sleeps most of the time, is not: one more for five stalls.
int most_missing(int exposures, std::size_t stalls) { return exposures / 1000 + static_cast<int>(stalls / 5); }

TEST(AravisHil, EveryPairIsATrueOneByteForByteAndHardlyAnyIsMissing) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const Course course;
  for (const double rate_hz : {10.0, 30.0, 60.0}) {
    const auto period_us = static_cast<std::int64_t>(1e6 / rate_hz);
    const std::string log = test::scratch_dir() + "/sent.txt";
    Rig rig(course, {"--pingpong", "--log", log});
    const auto source = open(camera_options(course, rate_hz));
    ASSERT_NE(source, nullptr);
    EXPECT_EQ(take(*source, course, 60).wrong, 0);  // the start
    Judged all;
    for (int batch_index = 0;
         batch_index == 0 || (batch_index < 6 && all.missing > most_missing(all.exposures, all.stalls) &&
                              all.missing <= most_missing(1000, all.stalls) && all.exposures < 1000);
         ++batch_index) {
      test::StallWatch watch(std::min<std::int64_t>(4'000, period_us / 10));
      const Seen seen = take(*source, course, rate_hz < 20.0 ? 100 : 300);
      const std::vector<test::StallWatch::Stall> stalls = watch.stop();
      EXPECT_EQ(seen.wrong, 0) << rate_hz << " Hz; " << source->status();
      ASSERT_GE(seen.stamps_us.size(), 40U) << source->status();
      const Judged batch = judge(seen, log, stalls, period_us);
      all.exposures += batch.exposures;
      all.missing += batch.missing;
      all.stalls += batch.stalls;
    }
    EXPECT_LE(all.missing, most_missing(all.exposures, all.stalls))
        << rate_hz << " Hz, " << all.exposures << " judged; " << source->status();
    std::printf(
        "%g Hz: %d of %d exposures that no stall was near to are "
        "missing (%zu stalls); %s\n",
        rate_hz, all.missing, all.exposures, all.stalls, source->status().c_str());
  }
}

TEST(AravisHil, WithLossAndLateLostAndSwappedFramesNoPairIsFalseOrTorn) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const Course course;
  for (const std::vector<std::string>& fault : {std::vector<std::string>{"--loss", "0.002"},
                                                {"--drop-every", "7"},
                                                {"--swap-every", "70"},
                                                {"--right-late", "0.01"}}) {
    std::vector<std::string> arguments{"--pingpong"};
    arguments.insert(arguments.end(), fault.begin(), fault.end());
    Rig rig(course, arguments);
    const auto source = open(camera_options(course, 20.0));
    ASSERT_NE(source, nullptr);
    const Seen seen = take(*source, course, 90);
    EXPECT_EQ(seen.pairs, 90) << fault[0] << "; " << source->status();
    EXPECT_EQ(seen.wrong, 0) << fault[0];
    if (fault[0] == "--loss") {
      EXPECT_NE(source->status().find("incomplete"), std::string::npos) << source->status();
    }
  }
}

TEST(AravisHil, CamerasThatAreKilledAndComeBackArePairedAgain) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const Course course;
  Rig rig(course, {"--pingpong"});
  drivers::CameraOptions options = camera_options(course, 20.0);
  options.shared_clock = false;  // their clocks must be learnt anew, too
  const auto source = open(options);
  ASSERT_NE(source, nullptr);
  EXPECT_EQ(take(*source, course, 20).wrong, 0);
  rig.kill();
  rig.start();
  const auto back_ns = monotonic_ns();
  StereoPair pair;
  const Seen seen = take(*source, course, 40);
  EXPECT_EQ(seen.pairs, 40) << source->status();
  EXPECT_EQ(seen.wrong, 0);
  RecordProperty("seconds_for_40_pairs_after_the_kill",
                 std::to_string(static_cast<double>(monotonic_ns() - back_ns) * 1e-9));
}

// Opened alone, as the program before left it.
struct Setting {
  double exposure_us = 0.0;
  double gain = 0.0;
};
Setting setting_of(const std::string& name, drivers::CameraOptions options) {
  options.exposure_us.reset();
  options.gain.reset();
  const auto give_up = steady_clock::now() + std::chrono::seconds(20);
  for (auto trouble = drivers::OpenTrouble::held;
       trouble != drivers::OpenTrouble::lasting && steady_clock::now() < give_up;) {
    auto camera = drivers::AravisCamera::open(name, options, true, trouble);
    if (camera.ok()) return {camera->exposure_us().value_or(0.0), camera->gain().value_or(0.0)};
  }
  ADD_FAILURE() << name << " does not answer";
  return {};
}

TEST(AravisHil, TheRightCameraTakesOverWhatTheLeftOnesControlFound) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const Course course;
  Rig rig(course, {"--pingpong"});
  rig.wait_until_seen();
  drivers::CameraOptions options = camera_options(course, 10.0);
  for (const double exposure_us : {4321.0, 1234.0}) {
    // What a control loop would do: the simulated cameras have none.
    const auto left_control = [&] {
      drivers::CameraOptions left = options;
      left.exposure_us = exposure_us;
      left.gain = 3.0;
      drivers::OpenTrouble ignored = drivers::OpenTrouble::lasting;
      EXPECT_TRUE(drivers::AravisCamera::open("HIL-LEFT", left, false, ignored).ok());
    };
    left_control();
    EXPECT_NE(setting_of("HIL-RIGHT", options).exposure_us, exposure_us);
    drivers::CameraOptions automatic = options;
    automatic.exposure_us.reset();
    automatic.gain.reset();
    {
      const auto source = open(automatic);
      ASSERT_NE(source, nullptr);
      EXPECT_EQ(take(*source, course, 20).pairs, 20) << source->status();
    }
    const Setting right = setting_of("HIL-RIGHT", options);
    EXPECT_EQ(right.exposure_us, exposure_us);
    EXPECT_EQ(right.gain, 3.0);
  }
}

TEST(AravisHil, ALimitOfTheExposureTimeHoldsWhereTheCamerasOwnControlHasNone) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const Course course;
  Rig rig(course, {"--pingpong"});
  rig.wait_until_seen();
  drivers::CameraOptions options = camera_options(course, 10.0);
  options.exposure_us.reset();
  options.gain.reset();
  {
    drivers::CameraOptions left = options;
    left.exposure_us = 9000.0;
    drivers::OpenTrouble ignored = drivers::OpenTrouble::lasting;
    EXPECT_TRUE(drivers::AravisCamera::open("HIL-LEFT", left, false, ignored).ok());
  }
  options.exposure_max_us = 2000.0;
  {
    const auto source = open(options);
    ASSERT_NE(source, nullptr);
    EXPECT_EQ(take(*source, course, 20).pairs, 20) << source->status();
  }
  options.exposure_max_us = 0.0;
  const Setting left = setting_of("HIL-LEFT", options);
  EXPECT_GT(left.exposure_us, 0.0);
  EXPECT_LE(left.exposure_us, 2000.0);
  EXPECT_LE(setting_of("HIL-RIGHT", options).exposure_us, 2000.0);
}

TEST(AravisHil, SoftwareTriggersExposeBothCamerasTogether) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const Course course;
  Rig rig(course, {"--pingpong"});
  drivers::CameraOptions options = camera_options(course, 10.0);
  options.trigger = drivers::CameraTrigger::software;
  const auto source = open(options);
  ASSERT_NE(source, nullptr);
  const Seen seen = take(*source, course, 30);
  EXPECT_EQ(seen.pairs, 30) << source->status();
  EXPECT_EQ(seen.wrong, 0);
}

}  // namespace
}  // namespace cliquevo
