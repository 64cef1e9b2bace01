// SPDX-License-Identifier: BSD-3-Clause
// Recordings as users bring them, through the real program: exit code and sentence.
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <regex>

#include <fmt/format.h>

#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"
#include "tests/system/made_recording.h"

namespace cliquevo::test {
namespace {

namespace fs = std::filesystem;

Finished replay(const std::string& source, std::vector<std::string> more = {}) {
  more.insert(more.begin(), {binary("cliquevo"), "replay", source});
  return run(more);
}

double way_of(const Finished& done) {
  std::smatch found;
  const std::regex way("frames .*, ([0-9.]+) m\n");
  return std::regex_search(done.out, found, way) ? std::stod(found[1]) : -1.0;
}

TEST(FieldRecordings, ExchangedCamerasAreReportedAndSwappedOnRequest) {
  CLIQUEVO_NEEDS_FIELD("17-eyes-swapped");
  const std::string source = field_dir() + "/17-eyes-swapped";
  const Finished as_is = replay(source);
  EXPECT_EQ(as_is.exit_code, 0) << as_is.err;
  EXPECT_NE(as_is.out.find("left and right are exchanged"), std::string::npos) << as_is.out;
  EXPECT_EQ(as_is.out.find("rotation of the right camera"), std::string::npos) << as_is.out;
  EXPECT_EQ(as_is.out.find("agrees with the images"), std::string::npos) << as_is.out;
  const Finished swapped = replay(source, {"--swap-eyes"});
  EXPECT_EQ(swapped.exit_code, 0) << swapped.err;
  EXPECT_EQ(swapped.out.find("exchanged"), std::string::npos) << swapped.out;
  EXPECT_NEAR(way_of(swapped), 3 * 0.06, 0.003) << swapped.out;
  const std::string config = scratch_dir() + "/c.yaml";
  std::ofstream(config) << "source:\n  swap_eyes: true\n";
  EXPECT_NEAR(way_of(replay(source, {"--config", config})), 3 * 0.06, 0.003);
}

TEST(FieldRecordings, TheSamePictureInBothCamerasIsReported) {
  const std::string recording = made_recording();
  for (int i = 0; i < 6; ++i) {
    fs::copy_file(image_of(recording, 0, i), image_of(recording, 1, i), fs::copy_options::overwrite_existing);
  }
  const Finished done = replay(recording);
  EXPECT_EQ(done.exit_code, 0) << done.err;
  EXPECT_NE(done.out.find("same picture"), std::string::npos) << done.out;
}

TEST(FieldRecordings, WhatWasNeverSeenIsNotCheckedInsteadOfAgreeing) {
  const std::string recording = made_recording();
  const Finished done = replay(recording, {"--last", "0"});
  EXPECT_NE(done.out.find("not checked: no evidence yet"), std::string::npos) << done.out;
}

TEST(FieldRecordings, LogsOfTheField) {
  CLIQUEVO_NEEDS_FIELD("22-lcm-logs");
  const std::string dir = field_dir() + "/22-lcm-logs";
  const std::vector<std::string> calibration{"--calibration", dir + "/calib.txt"};
  const Finished jpeg = replay(dir + "/jpeg.lcm", calibration);
  EXPECT_EQ(jpeg.exit_code, 0) << jpeg.err;
  EXPECT_NE(jpeg.out.find("frames       3"), std::string::npos) << jpeg.out;
  const Finished step = replay(dir + "/step_back.lcm", calibration);
  EXPECT_EQ(step.exit_code, 0) << step.err;
  EXPECT_NE(step.out.find("frames       3"), std::string::npos) << step.out;
  EXPECT_NE(step.err.find("skipped pair 2"), std::string::npos) << step.err;
  EXPECT_EQ(lines_of(step.err).size(), 1u) << step.err;
  const Finished two = replay(dir + "/two_channels.lcm", calibration);
  EXPECT_EQ(two.exit_code, 1);
  EXPECT_EQ(lines_of(two.err).size(), 1u);
  EXPECT_NE(two.err.find("REAR_STEREO"), std::string::npos) << two.err;
  EXPECT_EQ(
      replay(dir + "/two_channels.lcm", {"--calibration", dir + "/calib.txt", "--channel", "FRONT_STEREO"}).exit_code,
      0);
}

TEST(FieldRecordings, Kitti360PosesServeAsReferenceByFrameNumber) {
  const std::string estimate = scratch_dir() + "/t.txt";
  const std::string reference = scratch_dir() + "/cam0_to_world.txt";
  std::ofstream out(estimate);
  std::ofstream ref(reference);
  for (int i = 0; i < 40; ++i) {
    out << fmt::format("1 0 0 0 0 1 0 0 0 0 1 {}\n", i);
    if (i % 3 != 1) ref << fmt::format("{} 0 0 1 {} -1 0 0 900 0 -1 0 30 0 0 0 1\n", i, 500 + i);
  }
  out.close();
  ref.close();
  const Finished eval =
      run({binary("cliquevo"), "eval", "--reference", reference, "--estimate", estimate, "--lengths", "10"});
  ASSERT_EQ(eval.exit_code, 0) << eval.err;
  EXPECT_NE(eval.out.find("end          0.0000 m"), std::string::npos) << eval.out;
  EXPECT_NE(eval.out.find("segments     0.0000 %"), std::string::npos) << eval.out;
}

}  // namespace
}  // namespace cliquevo::test
