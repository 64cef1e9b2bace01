// SPDX-License-Identifier: BSD-3-Clause
// Recording with the real programs: what goes in comes out, whatever happens in between.
#include "drivers/recording.h"

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <map>
#include <unistd.h>

#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>

#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo {
namespace {

namespace fs = std::filesystem;
using test::Finished;

std::string tool() { return test::binary("cliquevo"); }

std::string trajectory_of(const std::string& source, const std::vector<std::string>& more = {}) {
  const std::string path = test::scratch_dir() + "/trajectory.txt";
  std::vector<std::string> command{tool(), "replay", source, "--trajectory", path};
  command.insert(command.end(), more.begin(), more.end());
  const Finished end = test::run(command);
  EXPECT_EQ(end.exit_code, 0) << end.err;
  return test::read_file(path);
}

Finished convert(const std::string& source, const std::string& out, const std::vector<std::string>& more = {}) {
  std::vector<std::string> command{tool(), "convert", source, out};
  command.insert(command.end(), more.begin(), more.end());
  return test::run(command);
}

// Events on each channel.
std::map<std::string, int> channels_of(const std::string& path) {
  lcm::LogFile log(path, "r");
  std::map<std::string, int> out;
  while (const lcm::LogEvent* event = log.readNextEvent()) ++out[event->channel];
  return out;
}

// Every pair of the log can be read; returns their number, -1 when it cannot be opened.
std::int64_t whole_pairs(const std::string& path) {
  drivers::RecordingOptions options;
  options.path = path;
  const auto source = drivers::open_recording(options);
  if (!source.ok()) return -1;
  drivers::StereoPair pair;
  std::int64_t count = 0;
  for (;; ++count) {
    const auto more = (*source)->next(pair);
    EXPECT_TRUE(more.ok()) << more.error().line();
    if (!more.ok() || !*more) break;
  }
  EXPECT_EQ(count, (*source)->info().frame_count);
  return count;
}

constexpr const char* kSmall = "sim:width=256,height=192,focal_px=280,frames=12";

TEST(RecordTool, ALogsTrajectoryIsByteForByteTheOneOfItsSource) {
  const std::string log = test::scratch_dir() + "/a.lcm";
  for (const std::string& source : {std::string(kSmall), std::string(kSmall) + ",raw=on"}) {
    fs::remove(log);
    const Finished record = test::run({tool(), "record", source, "--out", log});
    ASSERT_EQ(record.exit_code, 0) << record.err;
    EXPECT_EQ(trajectory_of(log), trajectory_of(source)) << source;
  }
}

TEST(RecordTool, ALogOfARecordedDriveGivesTheSameTrajectory) {
  CLIQUEVO_NEEDS_DATA("kitti_raw");
  CLIQUEVO_NEEDS_DATA("kitti_odometry_06");
  const std::string dir = test::scratch_dir();
  for (const char* name : {"kitti_raw", "kitti_odometry_06"}) {
    const std::string source = test::data_dir() + "/" + name;
    const std::string log = dir + "/" + name + ".lcm";
    ASSERT_EQ(test::run({tool(), "record", source, "--seconds", "0.75", "--out", log}).exit_code, 0);
    ASSERT_EQ(whole_pairs(log), 8);
    EXPECT_EQ(trajectory_of(log), trajectory_of(source, {"--last", "7"})) << name;
  }
}

TEST(RecordTool, ConvertingThereAndBackKeepsPixelsStampsAndMotion) {
  const std::string dir = test::scratch_dir();
  for (const bool raw : {false, true}) {
    const std::string source = std::string(kSmall) + (raw ? ",raw=on" : "");
    const std::string name = dir + (raw ? "/raw" : "/rectified");
    ASSERT_EQ(convert(source, name + ".lcm").exit_code, 0);
    const Finished folder = convert(name + ".lcm", name);
    ASSERT_EQ(folder.exit_code, 0) << folder.err;
    EXPECT_EQ(fs::exists(name + "/mav0"), raw) << "EuRoC as grabbed, KITTI rectified";
    EXPECT_EQ(fs::exists(name + "/calib.txt"), !raw);
    ASSERT_EQ(convert(name, name + "2.lcm").exit_code, 0);
    drivers::RecordingOptions first;
    first.path = name + ".lcm";
    drivers::RecordingOptions second;
    second.path = name + "2.lcm";
    const auto a = drivers::open_recording(first);
    const auto b = drivers::open_recording(second);
    ASSERT_TRUE(a.ok() && b.ok());
    drivers::StereoPair pa;
    drivers::StereoPair pb;
    for (int i = 0; i < 12; ++i) {
      ASSERT_TRUE((*a)->next(pa).ok() && (*b)->next(pb).ok());
      EXPECT_EQ(pa.stamp_ns, pb.stamp_ns);
      for (int y = 0; y < pa.left.height(); ++y) {
        ASSERT_TRUE(std::equal(pa.left.cview().row(y), pa.left.cview().row(y) + 256, pb.left.cview().row(y)));
        ASSERT_TRUE(std::equal(pa.right.cview().row(y), pa.right.cview().row(y) + 256, pb.right.cview().row(y)));
      }
    }
    if (!raw) {
      EXPECT_EQ(trajectory_of(name), trajectory_of(name + "2.lcm"));
    }
  }
  // As grabbed to rectified on the way.
  ASSERT_EQ(convert(dir + "/raw.lcm", dir + "/kitti", {"--to", "kitti"}).exit_code, 0);
  EXPECT_EQ(trajectory_of(dir + "/kitti"), trajectory_of(dir + "/raw.lcm"));
}

TEST(RecordTool, KilledAtAnyMomentItLeavesALogThatPlays) {
  const std::string dir = test::scratch_dir();
  ASSERT_EQ(test::run({tool(), "simulate", "--out", dir + "/course", "--width", "160", "--height", "120", "--focal-px",
                       "175", "--frames", "40"})
                .exit_code,
            0);
  std::int64_t played = 0;
  for (int attempt = 0; attempt < 20; ++attempt) {
    const std::string log = dir + "/" + std::to_string(attempt) + ".lcm";
    test::Subprocess record({tool(), "record", dir + "/course", "--out", log, "--speed", "2"});
    // Some are killed in their first moments, all at some point of a write or none.
    const std::uintmax_t enough = attempt < 2 ? 0 : static_cast<std::uintmax_t>(attempt) * 40'000;
    for (int i = 0; i < 20'000; ++i) {
      std::error_code ec;
      const auto size = fs::file_size(log, ec);
      if (!ec && size > enough) break;
      ::usleep(1000);
    }
    ::usleep(static_cast<useconds_t>(attempt * 777));
    record.send(SIGKILL);
    record.wait();
    const std::int64_t pairs = whole_pairs(log);
    if (attempt >= 2) {
      EXPECT_GE(pairs, 1) << "try " << attempt;
    }
    played += std::max<std::int64_t>(0, pairs);
  }
  EXPECT_GE(played, 100);
}

TEST(RecordTool, AFullDiskEndsItWithOneLineAndTheLogPlays) {
  if (::geteuid() != 0) GTEST_SKIP() << "needs root to mount a small disk";
  const std::string dir = test::scratch_dir();
  const std::string disk = dir + "/disk";
  fs::create_directories(disk);
  // No namespace of mounts: a chroot allows none.
  const std::string script = "mount -t tmpfs -o size=1m none " + disk + " && { " + tool() + " record " + kSmall +
                             " --out " + disk + "/a.lcm; code=$?; cp " + disk + "/a.lcm " + dir + "; umount " + disk +
                             "; exit $code; }";
  const Finished end = test::run({"sh", "-c", script});
  EXPECT_EQ(end.exit_code, 1) << end.err;
  EXPECT_EQ(test::lines_of(end.err).size(), 1U) << end.err;
  EXPECT_NE(end.err.find("No space left"), std::string::npos) << end.err;
  const std::int64_t pairs = whole_pairs(dir + "/a.lcm");
  EXPECT_EQ(pairs, 10);  // of 2 * 256 * 192 bytes and a little more
}

TEST(RecordTool, RotatesByNameAndSize) {
  const std::string dir = test::scratch_dir();
  const Finished end =
      test::run({tool(), "record", std::string(kSmall), "--out", dir + "/a.lcm", "--max-file-mb", "1"});
  ASSERT_EQ(end.exit_code, 0) << end.err;
  EXPECT_TRUE(fs::exists(dir + "/a-000.lcm") && fs::exists(dir + "/a-001.lcm"));
  EXPECT_EQ(trajectory_of(dir), trajectory_of(kSmall)) << "the folder plays as one recording";
}

TEST(DaemonRecording, HoldsEveryPairAndPoseAndReplaysToTheSameTrajectory) {
  const std::string dir = test::scratch_dir();
  std::ofstream(dir + "/c.yaml")
      << "source:\n  speed: 0\n  simulator: {width: 256, height: 192, focal_px: 280, frames: "
         "12}\nlcm: {url: \"file://" +
             dir + "/sent.lcm?mode=w\"}\nrecording: {folder: logs, at_start: true}\n";
  const Finished end =
      test::run({test::binary("cliquevod"), "--config", dir + "/c.yaml", "--trajectory", dir + "/t.txt"});
  ASSERT_EQ(end.exit_code, 0) << end.err;
  std::vector<std::string> logs;
  for (const auto& entry : fs::directory_iterator(dir + "/logs")) logs.push_back(entry.path().string());
  ASSERT_EQ(logs.size(), 1U);
  auto channels = channels_of(logs[0]);
  EXPECT_EQ(channels["VO_STEREO"], 12);
  EXPECT_EQ(channels["VO_CALIBRATION"], 1);
  EXPECT_EQ(channels["POSE_BODY"], 12);
  EXPECT_EQ(channels["VO_DELTA_CAMERA"], 12);
  EXPECT_EQ(channels["VO_STATUS"], 12);
  EXPECT_EQ(trajectory_of(logs[0]), test::read_file(dir + "/t.txt"));
}

TEST(DaemonRecording, AtStartWithoutAFolderIsRefused) {
  const std::string dir = test::scratch_dir();
  std::ofstream(dir + "/c.yaml") << "recording: {at_start: true}\n";
  const Finished end = test::run({test::binary("cliquevod"), "--config", dir + "/c.yaml", "--check"});
  EXPECT_EQ(end.exit_code, 1);
  EXPECT_NE(end.err.find("recording.folder"), std::string::npos) << end.err;
}

}  // namespace
}  // namespace cliquevo
