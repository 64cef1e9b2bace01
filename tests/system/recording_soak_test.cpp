// SPDX-License-Identifier: BSD-3-Clause
// Ten minutes of recording beside full odometry, at the pace of a camera: nothing is left out.
#include <csignal>
#include <filesystem>
#include <fstream>
#include <unistd.h>

#include <gtest/gtest.h>

#include "drivers/recording.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo {
namespace {

constexpr unsigned kSeconds = 600;

TEST(RecordingSoak, TenMinutesAt30HzBesideTheOdometryLeaveNothingOut) {
  const std::string dir = test::scratch_dir();
  std::ofstream(dir + "/c.yaml")
      << "source: {type: simulator, loop: pingpong, simulator: {width: 640, height: 480, focal_px: 700, frames: 60}}\n"
      << "recording: {folder: logs, at_start: true, max_file_mb: 500, max_total_mb: 2000}\n"
      << "lcm: {url: \"file://" << dir << "/sent.lcm?mode=w\"}\n";
  test::Subprocess daemon({test::binary("cliquevod"), "--config", dir + "/c.yaml"});
  for (unsigned left = kSeconds; left > 0;) left = ::sleep(left);
  daemon.send(SIGTERM);
  const test::Finished end = daemon.wait();
  EXPECT_EQ(end.exit_code, 0) << end.err;
  EXPECT_NE(end.err.find(" files, 0 left out"), std::string::npos) << end.err;
  drivers::RecordingOptions options;
  options.path = dir + "/logs";
  const auto source = drivers::open_recording(options);
  ASSERT_TRUE(source.ok()) << source.error().line();
  EXPECT_GT((*source)->info().frame_count, 1000) << "the newest files are there";
}

}  // namespace
}  // namespace cliquevo
