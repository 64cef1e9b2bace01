// SPDX-License-Identifier: BSD-3-Clause
// `cliquevo replay` as a user runs it: what it writes, and what it promises about it.
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <thread>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "daemon/pipeline/trajectory_file.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"
#include "tests/system/made_recording.h"

namespace cliquevo::test {
namespace {

using nlohmann::json;

const std::string kSmallCourse = "sim:width=320,height=240,focal_px=350,frames=12,cache_dir=none";

Finished replay(const std::string& source, std::vector<std::string> options = {}, const Environment& environment = {}) {
  options.insert(options.begin(), {binary("cliquevo"), "replay", source});
  return run(options, environment);
}

// The trajectory file's bytes.
std::string trajectory_of(const std::string& source, std::vector<std::string> options = {},
                          const Environment& environment = {}) {
  const std::string path = scratch_dir() + "/trajectory.txt";
  options.insert(options.end(), {"--trajectory", path});
  const Finished done = replay(source, options, environment);
  EXPECT_EQ(done.exit_code, 0) << done.err;
  return read_file(path);
}

json stats_of(const std::string& source, std::vector<std::string> options = {}) {
  const std::string path = scratch_dir() + "/stats.json";
  options.insert(options.end(), {"--stats", path});
  const Finished done = replay(source, options);
  EXPECT_EQ(done.exit_code, 0) << done.err;
  return json::parse(read_file(path));
}

std::string config_with(const std::string& text) {
  const std::string path = scratch_dir() + "/config.yaml";
  std::ofstream(path) << text;
  return path;
}

// ---- the same in, the same out --------------------------------------------------------------------------------------

TEST(Replay, TwoReplaysWriteTheSameBytes) {
  const std::string first = trajectory_of(kSmallCourse);
  EXPECT_EQ(lines_of(first).size(), 12u);
  EXPECT_EQ(first, trajectory_of(kSmallCourse));
}

TEST(Replay, TwoReplaysOfARecordingWriteTheSameBytes) {
  CLIQUEVO_NEEDS_DATA("kitti_odometry_06");
  const std::string source = data_dir() + "/kitti_odometry_06";
  const std::string first = trajectory_of(source);
  EXPECT_EQ(lines_of(first).size(), 51u);
  EXPECT_EQ(first, trajectory_of(source));
}

TEST(Replay, TheTrajectoryDoesNotDependOnWorkersOrInstructionSet) {
  const std::string recording = made_recording(8);
  const std::string plain = trajectory_of(recording);
  for (const char* isa : {"reference", "sse4", "avx2"}) {
    EXPECT_EQ(plain, trajectory_of(recording, {}, {{"CLIQUEVO_ISA", isa}})) << isa;
  }
  for (const int workers : {2, 3, 7}) {
    const std::string config = config_with(fmt::format("stereo:\n  workers: {}\n", workers));
    EXPECT_EQ(plain, trajectory_of(recording, {"--config", config})) << workers << " workers";
  }
}

TEST(Replay, PublishingDrawingAndPaceChangeNothing) {
  const std::string recording = made_recording();
  const std::string plain = trajectory_of(recording);
  const std::string folder = scratch_dir();
  EXPECT_EQ(plain, trajectory_of(recording, {"--speed", "2", "--plot", folder + "/p.png", "--stats", folder + "/s.json",
                                             "--lcm", "memq://"}));
}

// ---- what is written ------------------------------------------------------------------------------------------------

TEST(Replay, ATrajectoryHasALineAPairAlsoForFailedFramesAndStartsAtTheIdentity) {
  const std::string recording = made_recording(8);
  blank_pair(recording, 4);
  const auto lines = lines_of(trajectory_of(recording));
  ASSERT_EQ(lines.size(), 8u);
  const auto parsed = daemon::read_trajectory([&] {
    const std::string path = scratch_dir() + "/t.txt";
    std::ofstream out(path);
    for (const auto& line : lines) out << line << '\n';
    return path;
  }());
  ASSERT_TRUE(parsed.ok()) << parsed.error().line();
  const RigidTransform& first = parsed->poses[0].T_world_camera;
  EXPECT_EQ((first.R - Eigen::Matrix3d::Identity()).norm() + first.t.norm(), 0.0);
  // At least nine significant digits: 1.234567890e+00
  const std::string number = lines[3].substr(0, lines[3].find(' '));
  EXPECT_GE(std::count_if(number.begin(), number.begin() + static_cast<std::ptrdiff_t>(number.find('e')), ::isdigit),
            9);
}

TEST(Replay, AFailedFrameIsReportedAndStrictMakesItExitCode3) {
  const std::string recording = made_recording(8);
  blank_pair(recording, 4);
  const json stats = stats_of(recording);
  EXPECT_NE(stats["frames"][4]["status_code"], 1);
  EXPECT_EQ(stats["summary"]["failed"], 1);
  EXPECT_EQ(stats["frames"][5]["status_code"], 1);  // spans the gap
  const Finished strict = replay(recording, {"--strict"});
  EXPECT_EQ(strict.exit_code, 3);
  EXPECT_EQ(lines_of(strict.err).size(), 1u) << strict.err;
  EXPECT_EQ(replay(made_recording(8), {"--strict"}).exit_code, 0);
}

TEST(Replay, TumLinesCarryTheRecordingsStamps) {
  const std::string recording = made_recording();
  const auto tum = lines_of(trajectory_of(recording, {"--format", "tum"}));
  const auto times = lines_of(read_file(recording + "/times.txt"));
  ASSERT_EQ(tum.size(), times.size());
  for (std::size_t i = 0; i < tum.size(); ++i) EXPECT_NEAR(std::stod(tum[i]), std::stod(times[i]), 1e-6);
  EXPECT_NE(tum[0].find(" 0.000000000000e+00 1.000000000000e+00"), std::string::npos) << tum[0];
}

TEST(Replay, StatsTellStatusCountsErrorsAndTimesOfEachFrame) {
  const json stats = stats_of(made_recording());
  ASSERT_EQ(stats["frames"].size(), 6u);
  EXPECT_EQ(stats["frames"][0]["status_code"], 0);
  for (std::size_t i = 0; i < 6; ++i) {
    const json& frame = stats["frames"][i];
    EXPECT_EQ(frame["index"], i);
    for (const char* key : {"stamp_ns", "status", "features", "matches", "clique", "inliers", "reprojection_error_px",
                            "eigenvalue_ratio", "T_prev_cur", "T_world_camera"}) {
      EXPECT_TRUE(frame.contains(key) && !frame[key].is_null()) << key;
    }
    for (const char* stage : {"read", "rectify", "stereo", "odometry", "total"}) {
      EXPECT_GE(frame["times_ms"][stage].get<double>(), 0.0) << stage;
    }
    if (i > 0) {
      EXPECT_GE(frame["inliers"].get<int>(), 10);
    }
  }
  EXPECT_EQ(stats["summary"]["frames"], 6);
  EXPECT_EQ(stats["camera"]["width"], 320);
}

TEST(Replay, TheStartTellsBaselineFocalLengthFieldOfViewAndDepthErrorAndTheEndVerdictsAndTimes) {
  const Finished done = replay(made_recording());
  for (const char* part : {"baseline 0.12", "focal length 350", "field of view", "at 5 m", "at 10 m", "at 20 m",
                           "verdicts", "5 valid", "stereo", "odometry", "ATE"}) {
    EXPECT_NE(done.out.find(part), std::string::npos) << part << " in\n" << done.out;
  }
  EXPECT_EQ(done.err, "");
}

TEST(Replay, FirstLastAndEveryPickPairs) {
  const std::string recording = made_recording(8);
  const json stats = stats_of(recording, {"--first", "1", "--last", "6", "--every", "2"});
  ASSERT_EQ(stats["frames"].size(), 3u);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(stats["frames"][i]["index"], 1 + 2 * i);
  const double step = stats["frames"][1]["T_world_camera"]["translation_m"][2].get<double>();
  EXPECT_NEAR(step, 0.2, 0.02);  // two steps of 0.1 m
}

TEST(Replay, APlotIsAPicture) {
  const std::string plot = scratch_dir() + "/plot.png";
  ASSERT_EQ(replay(made_recording(), {"--plot", plot}).exit_code, 0);
  EXPECT_GE(cv::imread(plot).cols, 1000);
}

TEST(Replay, SpeedKeepsTheRecordedPace) {
  const std::string recording = made_recording(8);  // seven steps of 1/30 s
  const json slow = stats_of(recording, {"--speed", "0.25"});
  EXPECT_GE(slow["summary"]["wall_s"].get<double>(), 7 / 30.0 / 0.25);
}

TEST(Replay, AnInterruptedReplayLeavesTheTrajectorySoFar) {
  const std::string folder = scratch_dir();
  Subprocess running({binary("cliquevo"), "replay", made_recording(8), "--speed", "0.05", "--trajectory",
                      folder + "/t.txt", "--stats", folder + "/s.json"});
  for (int i = 0; i < 2000 && lines_of(read_file(folder + "/t.txt")).size() < 3; ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  running.send(SIGINT);
  const Finished done = running.wait();
  EXPECT_EQ(done.exit_code, 1);
  EXPECT_NE(done.err.find("interrupted: after "), std::string::npos) << done.err;
  const auto trajectory = daemon::read_trajectory(folder + "/t.txt");
  ASSERT_TRUE(trajectory.ok()) << trajectory.error().line();
  EXPECT_GE(trajectory->poses.size(), 3u);
  EXPECT_LT(trajectory->poses.size(), 8u);
  EXPECT_EQ(json::parse(read_file(folder + "/s.json"))["frames"].size(), trajectory->poses.size());
}

TEST(Replay, TheConfigurationReachesTheStages) {
  const std::string recording = made_recording();
  const json few = stats_of(recording, {"--config", config_with("odometry:\n  max_features: 60\n")});
  for (const json& frame : few["frames"]) EXPECT_LE(frame["features"].get<int>(), 60);
}

TEST(Replay, AMaskKeepsFeaturesAwayAndChangesNothingElse) {
  const std::string recording = made_recording();
  cv::Mat mask(240, 320, CV_8UC1, cv::Scalar(255));
  cv::imwrite(recording + "/all.png", mask);
  const std::string everything =
      config_with(fmt::format("source: {{recording: {{left_mask: {}/all.png}}}}\n", recording));
  EXPECT_EQ(trajectory_of(recording), trajectory_of(recording, {"--config", everything}));
  for (const char* side : {"left_mask", "right_mask"}) {
    mask.setTo(0);
    cv::imwrite(recording + "/none.png", mask);
    const std::string nothing =
        config_with(fmt::format("source: {{recording: {{{}: {}/none.png}}}}\n", side, recording));
    for (const json& frame : stats_of(recording, {"--config", nothing})["frames"])
      EXPECT_EQ(frame["features"], 0) << side;
  }
}

}  // namespace
}  // namespace cliquevo::test
