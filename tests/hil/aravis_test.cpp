// SPDX-License-Identifier: BSD-3-Clause
// GigE Vision cameras over the real protocol: `cliquevo hil` serves them, the driver or the daemon takes them. Whatever
// happens, no pair may be of two exposures and no image torn.
#include "drivers/aravis.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <set>
#include <thread>

#include <gtest/gtest.h>

#include "drivers/aravis/aravis_camera.h"
#include "drivers/recording.h"
#include "tests/hil/private_network.h"
#include "tests/support/stall_watch.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo {
namespace {

using drivers::StereoPair;
using std::chrono::steady_clock;

constexpr int kFrames = 30;

bool enter_network_with_two_addresses() {
  return test::enter_private_network() &&
         std::system("for i in 2 3 4; do ip address add 127.0.0.$i/8 dev lo; done") == 0;
}

std::uint64_t hash_of(ImageView<const std::uint8_t> image) {
  std::uint64_t hash = 1469598103934665603U;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) hash = (hash ^ image(x, y)) * 1099511628211U;
  }
  return hash;
}

// A rendered course on disk, and what its images are known by.
class Course {
 public:
  Course() : folder(test::scratch_dir() + "/course") {
    const test::Finished end = test::run({test::binary("cliquevo"), "simulate", "--out", folder, "--width", "320",
                                          "--height", "240", "--focal-px", "350", "--frames", std::to_string(kFrames)});
    EXPECT_EQ(end.exit_code, 0) << end.err;
    drivers::RecordingOptions options;
    options.path = folder;
    auto source = drivers::open_recording(options);
    EXPECT_TRUE(source.ok());
    StereoPair pair;
    for (int i = 0; i < kFrames && source.ok() && (*source)->next(pair).ok(); ++i) {
      left_[hash_of(pair.left.cview())] = i;
      right_[hash_of(pair.right.cview())] = i;
    }
  }
  // Which pair it is, byte for byte; -1: none, so torn or of two exposures.
  int number_of(const StereoPair& pair) const {
    const auto l = left_.find(hash_of(pair.left.cview()));
    const auto r = right_.find(hash_of(pair.right.cview()));
    return l == left_.end() || r == right_.end() || l->second != r->second ? -1 : l->second;
  }
  const std::string folder;

 private:
  std::map<std::uint64_t, int> left_;
  std::map<std::uint64_t, int> right_;
};

// The simulated cameras as a user starts them.
class Rig {
 public:
  Rig(const Course& course, const std::vector<std::string>& more) {
    command_ = {test::binary("cliquevo"), "hil", course.folder};
    command_.insert(command_.end(), more.begin(), more.end());
    start();
  }
  void start() { process_ = std::make_unique<test::Subprocess>(command_); }
  // As soon as both answer.
  void wait_until_seen() const {
    for (int i = 0; i < 60 && drivers::list_aravis().size() < 2; ++i) {
    }
  }
  void kill() {
    process_->send(SIGKILL);
    process_->wait();
  }

 private:
  std::vector<std::string> command_;
  std::unique_ptr<test::Subprocess> process_;
};

drivers::CameraOptions camera_options(const Course& course, double rate_hz) {
  drivers::CameraOptions options;
  options.left = "HIL-LEFT";
  options.right = "HIL-RIGHT";
  options.calibration = course.folder + "/calib.txt";
  options.rate_hz = rate_hz;
  options.exposure_us = 10'000;
  options.gain = 0;
  options.shared_clock = true;
  return options;
}

// As soon as they answer.
std::unique_ptr<drivers::FrameSource> open(const drivers::CameraOptions& options) {
  const auto give_up = steady_clock::now() + std::chrono::seconds(60);
  for (;;) {
    drivers::OpenTrouble ignored = drivers::OpenTrouble::lasting;
    auto source = drivers::open_aravis(options, ignored);
    if (source.ok()) return std::move(*source);
    if (steady_clock::now() > give_up) {
      ADD_FAILURE() << source.error().line();
      return nullptr;
    }
  }
}

struct Seen {
  std::int64_t pairs = 0;
  std::int64_t wrong = 0;
  std::vector<std::int64_t> stamps_us;
};
// Takes pairs until `wanted` have come or none came for long.
Seen take(drivers::FrameSource& source, const Course& course, std::int64_t wanted) {
  Seen seen;
  StereoPair pair;
  std::atomic<std::int64_t> last_ns{monotonic_ns()};
  std::atomic<bool> done{false};
  std::thread guard([&] {
    while (!done) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      if (monotonic_ns() - last_ns > 60'000'000'000) source.interrupt();
    }
  });
  while (seen.pairs < wanted) {
    const auto more = source.next(pair);
    if (!more.ok() || !*more) break;
    last_ns = monotonic_ns();
    const int number = course.number_of(pair);
    seen.wrong += number < 0 ? 1 : 0;
    seen.stamps_us.push_back(pair.stamp_ns / 1000);
    ++seen.pairs;
  }
  done = true;
  guard.join();
  return seen;
}

#define CLIQUEVO_NEEDS_TWO_ADDRESSES() \
  if (!enter_network_with_two_addresses()) GTEST_SKIP() << "needs root and iproute2 for a network namespace"

// Stamps [us] of the exposures that both eyes sent.
std::set<std::int64_t> sent_by_both(const std::string& log) {
  std::set<std::int64_t> left;
  std::set<std::int64_t> both;
  std::ifstream in(log);
  std::int64_t stamp_us = 0;
  char eye = 0;
  int frame = 0;
  std::set<std::int64_t> right;
  while (in >> stamp_us >> eye >> frame) (eye == 'L' ? left : right).insert(stamp_us);
  std::set_intersection(left.begin(), left.end(), right.begin(), right.end(), std::inserter(both, both.end()));
  return both;
}

// Every exposure that both eyes sent must come as a pair, but for those that were sent while the machine stood still or
// just before or after: a camera would not have waited, and its packets would not have come in a lump.
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
    test::StallWatch watch(std::min<std::int64_t>(4'000, period_us / 10));
    const Seen seen = take(*source, course, rate_hz < 20.0 ? 100 : 300);
    const std::vector<test::StallWatch::Stall> stalls = watch.stop();
    EXPECT_EQ(seen.wrong, 0) << rate_hz << " Hz; " << source->status();
    ASSERT_GE(seen.stamps_us.size(), 40U) << source->status();
    const std::set<std::int64_t> taken(seen.stamps_us.begin(), seen.stamps_us.end());
    int judged = 0;
    int missing = 0;
    const std::set<std::int64_t> sent = sent_by_both(log);
    for (auto s = sent.lower_bound(seen.stamps_us.front()); s != sent.upper_bound(seen.stamps_us.back()); ++s) {
      const bool stalled = std::any_of(stalls.begin(), stalls.end(), [&](const test::StallWatch::Stall& stall) {
        return *s > stall.begin_us - 3 * period_us && *s < stall.end_us + 8 * period_us;
      });
      if (stalled) continue;
      ++judged;
      missing += taken.count(*s) == 0 ? 1 : 0;
    }
    EXPECT_LE(missing, judged / 1000) << rate_hz << " Hz, " << judged << " judged; " << source->status();
    std::printf("%g Hz: %d of %d exposures that no stall was near to are missing (%zu stalls); %s\n", rate_hz, missing,
                judged, stalls.size(), source->status().c_str());
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

// Asked by itself, as it was left by whoever had it before.
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

TEST(AravisHil, TheRightEyeTakesOverWhatTheLeftOnesControlFound) {
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

TEST(AravisHil, SoftwareTriggersExposeBothEyesTogether) {
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

std::string daemon_config(const Course& course, const std::string& dir, const std::string& more = "") {
  const std::string path = dir + "/c.yaml";
  std::ofstream(path) << "source:\n  type: aravis\n  cameras: {left: HIL-LEFT, right: HIL-RIGHT, calibration: "
                      << course.folder << "/calib.txt, rate_hz: 5, exposure_us: 10000, gain: 0, shared_clock: true"
                      << more << "}\n"
                      << "realtime: {lock_memory: false}\nlcm: {url: \"file://" << dir << "/sent.lcm?mode=w\"}\n";
  return path;
}

// Until the file has so many lines, or none has come for long.
std::size_t wait_for_poses(const std::string& path, std::size_t wanted) {
  std::size_t lines = 0;
  for (int quiet = 0; quiet < 1500; ++quiet) {
    const std::size_t now = test::lines_of(test::read_file(path)).size();
    if (now >= wanted) return now;
    if (now > lines) quiet = 0;
    lines = now;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return lines;
}

TEST(AravisHil, TheDaemonsTrajectoryIsByteForByteTheOneOfTheFiles) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const Course course;
  const std::string dir = test::scratch_dir();
  ASSERT_EQ(
      test::run({test::binary("cliquevo"), "replay", course.folder, "--trajectory", dir + "/replay.txt"}).exit_code, 0);
  bool equal = false;
  for (int attempt = 0; attempt < 4 && !equal; ++attempt) {  // where the machine is busy a frame may be dropped
    Rig rig(course, {});
    rig.wait_until_seen();
    const std::string trajectory = dir + "/daemon" + std::to_string(attempt) + ".txt";
    test::Subprocess daemon(
        {test::binary("cliquevod"), "--config", daemon_config(course, dir), "--trajectory", trajectory});
    wait_for_poses(trajectory, kFrames);
    daemon.send(SIGTERM);
    const test::Finished end = daemon.wait();
    EXPECT_EQ(end.exit_code, 0) << end.err;
    equal = test::read_file(trajectory) == test::read_file(dir + "/replay.txt");
    if (!equal) std::fprintf(stderr, "attempt %d: %s\n", attempt, end.err.c_str());
  }
  EXPECT_TRUE(equal);
}

TEST(AravisHil, ADaemonThatWasKilledGetsTheCamerasBackByItself) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const Course course;
  const std::string dir = test::scratch_dir();
  Rig rig(course, {"--pingpong"});
  rig.wait_until_seen();
  const std::string config = daemon_config(course, dir);
  for (const char* name : {"/first.txt", "/second.txt"}) {
    test::Subprocess daemon({test::binary("cliquevod"), "--config", config, "--trajectory", dir + name});
    EXPECT_GE(wait_for_poses(dir + name, 5), 5U) << name;
    daemon.send(SIGKILL);
    daemon.wait();
  }
}

TEST(AravisHil, TheRigTestSeesTheCamerasUnpluggedAndBack) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const Course course;
  const std::string dir = test::scratch_dir();
  Rig rig(course, {"--pingpong"});
  rig.wait_until_seen();
  test::Subprocess tool({"sh", "-c",
                         "exec " + test::binary("cliquevo") + " cameras test --seconds 1 --unplug --config " +
                             daemon_config(course, dir) + " >" + dir + "/out"});
  const auto told = [&](const std::string& words) {
    for (int i = 0; i < 1500; ++i) {
      if (test::read_file(dir + "/out").find(words) != std::string::npos) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
  };
  ASSERT_TRUE(told("unplug a camera"));
  std::this_thread::sleep_for(std::chrono::seconds(2));
  rig.kill();
  ASSERT_TRUE(told("lost") || told("reconnecting")) << test::read_file(dir + "/out");
  rig.start();
  EXPECT_TRUE(told("it came back: pairs flow")) << test::read_file(dir + "/out");
}

TEST(AravisHil, WhatCannotBeOpenedIsToldInOneLine) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const Course course;
  const std::string dir = test::scratch_dir();
  Rig rig(course, {"--pingpong"});
  const auto held = open(camera_options(course, 10.0));
  ASSERT_NE(held, nullptr);
  const auto refusal = [&](const std::string& config) {
    const test::Finished end = test::run({test::binary("cliquevod"), "--config", config, "--check"});
    EXPECT_EQ(end.exit_code, 1);
    EXPECT_EQ(test::lines_of(end.err).size(), 1U) << end.err;
    return end.err;
  };
  EXPECT_NE(refusal(daemon_config(course, dir)).find("busy"), std::string::npos);
  drivers::CameraOptions options = camera_options(course, 10.0);
  options.left = "NOT-THERE";
  drivers::OpenTrouble trouble = drivers::OpenTrouble::lasting;
  const auto unknown = drivers::open_aravis(options, trouble);
  ASSERT_FALSE(unknown.ok());
  EXPECT_EQ(trouble, drivers::OpenTrouble::absent);
  EXPECT_NE(unknown.error().line().find("HIL-LEFT (127.0.0.1), HIL-RIGHT (127.0.0.2)"), std::string::npos)
      << unknown.error().line();
}

TEST(AravisHil, FormatsAndSizesThatDoNotFitAreToldInOneLine) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const Course course;
  Rig rig(course, {"--pingpong"});
  open(camera_options(course, 10.0));
  drivers::CameraOptions options = camera_options(course, 10.0);
  options.pixel_format = "BayerXY8";
  drivers::OpenTrouble trouble = drivers::OpenTrouble::absent;
  const auto format = drivers::open_aravis(options, trouble);
  ASSERT_FALSE(format.ok());
  EXPECT_EQ(trouble, drivers::OpenTrouble::lasting);
  EXPECT_NE(format.error().line().find(", Mono8,"), std::string::npos) << format.error().line();
  // A second rig of another size: one eye of each.
  test::Subprocess other({test::binary("cliquevo"), "hil",
                          "sim:width=160,height=120,focal_px=175,frames=2,cache_dir=none", "--pingpong",
                          "--left-address", "127.0.0.3", "--right-address", "127.0.0.4", "--left-serial", "OTHER-LEFT",
                          "--right-serial", "OTHER-RIGHT"});
  options = camera_options(course, 10.0);
  options.left = "127.0.0.1";
  options.right = "127.0.0.4";
  std::string line;
  for (int i = 0; i < 30 && line.find("unequal") == std::string::npos; ++i) {
    const auto unequal = drivers::open_aravis(options, trouble);
    ASSERT_FALSE(unequal.ok());
    line = unequal.error().line();
  }
  EXPECT_NE(line.find("320x240 and 160x120"), std::string::npos) << line;
}

TEST(AravisHil, TheListNamesWhatAnswers) {
  CLIQUEVO_NEEDS_TWO_ADDRESSES();
  const Course course;
  Rig rig(course, {"--pingpong"});
  std::vector<drivers::SeenCamera> seen;
  for (int i = 0; i < 30 && seen.size() < 2; ++i) seen = drivers::list_aravis();
  ASSERT_EQ(seen.size(), 2U);
  EXPECT_EQ(seen[0].id.substr(0, 4), "HIL-");
}

}  // namespace
}  // namespace cliquevo
