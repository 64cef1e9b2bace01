// SPDX-License-Identifier: BSD-3-Clause
// `cliquevo eval` against an independent scorer, and its own promises.
#include <filesystem>
#include <fstream>
#include <random>

#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "daemon/pipeline/trajectory_file.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {
namespace {

using daemon::format_pose;
using daemon::TrajectoryFormat;
using nlohmann::json;

struct Drive {
  std::string reference;
  std::string estimate;
};

// A winding drive of `count` poses, and the same with noise on every motion.
Drive drive(std::uint32_t seed, int count, TrajectoryFormat format, int estimate_count) {
  std::mt19937 rng(seed);
  std::normal_distribution<double> normal;
  const std::string folder = scratch_dir();
  Drive out{folder + "/reference.txt", folder + "/estimate.txt"};
  std::ofstream reference(out.reference);
  std::ofstream estimate(out.estimate);
  RigidTransform T;
  RigidTransform E;
  double turn = 0.0;
  for (int i = 0; i < count; ++i) {
    const TimestampNs stamp = i * 100'000'000LL;
    reference << format_pose(format, stamp, T) << '\n';
    if (i < estimate_count) estimate << format_pose(format, stamp + 3'000'000, E) << '\n';
    turn = 0.9 * turn + 0.01 * normal(rng);
    const RigidTransform step = perturb_left(
        {}, (Vector6d() << 0, 0.01 * normal(rng), 0.8 + 0.1 * normal(rng), 0.002 * normal(rng), turn, 0).finished());
    Vector6d noise;
    for (int k = 0; k < 6; ++k) noise[k] = (k < 3 ? 0.01 : 0.001) * normal(rng);
    T = T * step;
    E = E * step * perturb_left({}, noise);
  }
  return out;
}

Finished eval(const Drive& d, std::vector<std::string> options = {}) {
  options.insert(options.begin(), {binary("cliquevo"), "eval", "--reference", d.reference, "--estimate", d.estimate});
  return run(options);
}

std::string scorer() { return data_dir() + "/../score/trajectory.py"; }

// Both round: the scorer to so many decimals.
void expect_same(const json& ours, const json& theirs, const char* key, double rounding) {
  if (theirs[key].is_null()) {
    EXPECT_TRUE(ours[key].is_null()) << key;
  } else {
    EXPECT_NEAR(ours[key].get<double>(), theirs[key].get<double>(), rounding) << key;
  }
}

void expect_agreement(const Drive& d, const std::string& lengths) {
  const json ours = json::parse(eval(d, {"--json", "--lengths", lengths}).out);
  const json theirs = json::parse(run({"python3", scorer(), d.reference, d.estimate, lengths}).out);
  EXPECT_EQ(ours["frames_ref"], theirs["frames_ref"]);
  EXPECT_EQ(ours["frames_est"], theirs["frames_est"]);
  EXPECT_EQ(ours["segments"], theirs["segments"]);
  expect_same(ours, theirs, "path_m", 5.1e-4);
  expect_same(ours, theirs, "path_est_m", 5.1e-4);
  expect_same(ours, theirs, "t_err_pct", 5.1e-5);
  expect_same(ours, theirs, "r_err_deg_m", 5.1e-7);
  expect_same(ours, theirs, "rpe_cm", 5.1e-4);
  expect_same(ours, theirs, "end_pct", 5.1e-5);
  expect_same(ours, theirs, "end_m", 5.1e-5);
}

TEST(Eval, AgreesWithTheIndependentScorer) {
  if (!std::filesystem::exists(scorer())) GTEST_SKIP() << "no scorer at " << scorer();
  for (const std::uint32_t seed : {1u, 2u, 3u}) {
    expect_agreement(drive(seed, 180, TrajectoryFormat::kitti, 180), "10,20,40,60,80,100");
  }
  expect_agreement(drive(4, 100, TrajectoryFormat::kitti, 70), "5,10,20,40");  // an estimate that ends early
  expect_agreement(drive(5, 8, TrajectoryFormat::kitti, 8), "100");            // shorter than every length
}

TEST(Eval, AgreesWithTheIndependentScorerOnTheOfficialPoses) {
  CLIQUEVO_NEEDS_DATA("kitti_odometry_06");
  if (!std::filesystem::exists(scorer())) GTEST_SKIP() << "no scorer at " << scorer();
  Drive d = drive(6, 51, TrajectoryFormat::kitti, 51);
  d.reference = data_dir() + "/kitti_odometry_06/poses.txt";  // rotations rounded to seven digits
  expect_agreement(d, "5,10,20,40");
}

TEST(Eval, StampsAreWhatJoinsTumTrajectories) {
  const Drive d = drive(7, 50, TrajectoryFormat::tum, 50);
  const json e = json::parse(eval(d, {"--json"}).out);
  EXPECT_EQ(e["frames_compared"], 50);  // 3 ms apart
  EXPECT_EQ(eval(d, {"--json", "--tolerance", "0.001"}).exit_code, 1);
}

TEST(Eval, TableAndPictureHoldWhatTheJsonHolds) {
  const Drive d = drive(8, 100, TrajectoryFormat::kitti, 100);
  const std::string plot = scratch_dir() + "/e.png";
  const Finished table = eval(d, {"--plot", plot});
  EXPECT_EQ(table.exit_code, 0);
  const json e = json::parse(eval(d, {"--json"}).out);
  char expected[64];
  std::snprintf(expected, sizeof expected, "%.4f %%", e["t_err_pct"].get<double>());
  EXPECT_NE(table.out.find(expected), std::string::npos) << table.out;
  for (const char* name : {"ATE", "RPE", "end", "path", "segments"}) EXPECT_NE(table.out.find(name), std::string::npos);
  EXPECT_GE(cv::imread(plot).cols, 1000);
}

TEST(Eval, MixedFormatsAndBrokenFilesAreOneLine) {
  const Drive kitti = drive(9, 20, TrajectoryFormat::kitti, 20);
  const Drive tum = drive(9, 20, TrajectoryFormat::tum, 20);
  const std::string broken = scratch_dir() + "/broken.txt";
  std::ofstream(broken) << "1 2 3\n";
  for (const Drive& d : {Drive{kitti.reference, tum.estimate}, Drive{kitti.reference, broken},
                         Drive{"/nowhere/poses.txt", kitti.estimate}}) {
    const Finished done = eval(d);
    EXPECT_EQ(done.exit_code, 1);
    EXPECT_EQ(lines_of(done.err).size(), 1u) << done.err;
  }
}

TEST(Eval, AReferenceInBodyAxesIsNoticedAndCanBeTold) {
  CLIQUEVO_NEEDS_DATA("zed_indoor");
  const std::string reference = data_dir() + "/zed_indoor/groundtruth.tum";
  const std::string estimate = scratch_dir() + "/t.tum";
  ASSERT_EQ(run({binary("cliquevo"), "replay", data_dir() + "/zed_indoor", "--last", "40", "--format", "tum",
                 "--trajectory", estimate})
                .exit_code,
            0);
  EXPECT_NE(eval({reference, estimate}).err.find("--reference-frame body"), std::string::npos);
  const Finished reported = eval({reference, estimate}, {"--reference-frame", "body", "--json"});
  EXPECT_EQ(reported.err, "");
  EXPECT_LT(json::parse(reported.out)["rpe_cm"].get<double>(), 2.0);
}

}  // namespace
}  // namespace cliquevo::test
