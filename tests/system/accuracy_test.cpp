// SPDX-License-Identifier: BSD-3-Clause
// How well the program as shipped measures motion: recorded sequences and short simulated courses, replayed and judged
// by the real binary.
#include <cmath>

#include <nlohmann/json.hpp>

#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {
namespace {

using nlohmann::json;

// Replays with --strict (every frame must be valid) and returns the trajectory's path.
std::string strict_replay(const std::string& source, const std::string& format = "kitti") {
  const std::string path = scratch_dir() + "/trajectory.txt";
  const Finished done =
      run({binary("cliquevo"), "replay", source, "--strict", "--trajectory", path, "--format", format});
  EXPECT_EQ(done.exit_code, 0) << done.err;
  return path;
}

json judge(const std::string& reference, const std::string& estimate, std::vector<std::string> options = {}) {
  options.insert(options.begin(),
                 {binary("cliquevo"), "eval", "--json", "--reference", reference, "--estimate", estimate});
  const Finished done = run(options);
  EXPECT_EQ(done.exit_code, 0) << done.err;
  return json::parse(done.out);
}

TEST(Accuracy, KittiOdometrySegmentErrorIsBelowSevenTenthsOfAPercent) {
  CLIQUEVO_NEEDS_DATA("kitti_odometry_06");
  const std::string source = data_dir() + "/kitti_odometry_06";
  const json e = judge(source + "/poses.txt", strict_replay(source), {"--lengths", "5,10,20,40"});
  EXPECT_EQ(e["frames_compared"], 51);
  EXPECT_LE(e["t_err_pct"].get<double>(), 0.7);
}

TEST(Accuracy, KittiRawRectifiedByOurselvesSegmentErrorIsBelowOnePointTwoPercent) {
  CLIQUEVO_NEEDS_DATA("kitti_raw");
  const std::string source = data_dir() + "/kitti_raw";
  const json e = judge(source + "/poses.txt", strict_replay(source), {"--lengths", "10,20,40,60,80,100"});
  EXPECT_EQ(e["frames_compared"], 140);
  EXPECT_LE(e["t_err_pct"].get<double>(), 1.2);
}

TEST(Accuracy, ThePlanetaryRoversStepIsRightWithinFivePercent) {
  CLIQUEVO_NEEDS_DATA("rover_minnie");
  const std::string path = strict_replay(data_dir() + "/rover_minnie");
  const auto lines = lines_of(read_file(path));
  ASSERT_EQ(lines.size(), 2u);
  std::istringstream second(lines[1]);
  double v[12] = {};
  for (double& value : v) second >> value;
  EXPECT_NEAR(std::sqrt(v[3] * v[3] + v[7] * v[7] + v[11] * v[11]), 0.153, 0.05 * 0.153);
}

TEST(Accuracy, HandHeldIndoorsPathIsWithinThreePercentAndPositionsWithinTwoAndAHalfCentimetres) {
  CLIQUEVO_NEEDS_DATA("zed_indoor");
  const std::string source = data_dir() + "/zed_indoor";
  const json e = judge(source + "/groundtruth.tum", strict_replay(source, "tum"), {"--sample-period", "0.2"});
  EXPECT_GE(e["frames_compared"].get<int>(), 80);
  EXPECT_NEAR(e["sampled_path_est_m"].get<double>() / e["sampled_path_m"].get<double>(), 1.0, 0.03);
  EXPECT_LE(e["ate_m"].get<double>(), 0.025);
}

// The simulator's own truth, from the statistics.
json against_truth(const std::string& source) {
  const std::string path = scratch_dir() + "/stats.json";
  const Finished done = run({binary("cliquevo"), "replay", source, "--strict", "--stats", path});
  EXPECT_EQ(done.exit_code, 0) << done.err;
  return json::parse(read_file(path));
}

TEST(Accuracy, AWheeledCourseEndsWithinATenthOfAPercent) {
  const json stats = against_truth("sim:course=wheeled,frames=200");
  EXPECT_EQ(stats["summary"]["frames"], 200);
  EXPECT_LE(stats["reference"]["end_pct"].get<double>(), 0.1);
}

TEST(Accuracy, AWalkingCourseEndsWithinATenthOfAPercent) {
  const json stats = against_truth("sim:course=walking,frames=200");
  EXPECT_EQ(stats["summary"]["frames"], 200);
  EXPECT_LE(stats["reference"]["end_pct"].get<double>(), 0.1);
}

// A third of the matches is true there: the clique alone does not find the motion.
TEST(Accuracy, AFastGaitAtTenHertzIsFollowed) {
  const json stats = against_truth("sim:course=walking,frames=93,noise_seed=5,every=3");
  EXPECT_EQ(stats["summary"]["frames"], 31);
  EXPECT_LE(stats["reference"]["end_m"].get<double>(), 0.02);
}

// 3.6 m a frame, from the first one on: no speed is known yet.
TEST(Accuracy, FastDrivingIsFollowedFromTheFirstFrameOn) {
  CLIQUEVO_NEEDS_DATA("kitti_odometry_06");
  const std::string path = scratch_dir() + "/stats.json";
  const Finished done = run(
      {binary("cliquevo"), "replay", data_dir() + "/kitti_odometry_06", "--every", "3", "--strict", "--stats", path});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  EXPECT_LE(json::parse(read_file(path))["reference"]["t_err_pct"].get<double>(), 1.0);
}

TEST(Accuracy, AStandingCameraStaysWhereItIs) {
  const json stats = against_truth("sim:course=standing,frames=300");
  for (const json& frame : stats["frames"]) EXPECT_LE(frame["truth_error"]["translation_m"].get<double>(), 0.002);
}

}  // namespace
}  // namespace cliquevo::test
