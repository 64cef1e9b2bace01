// SPDX-License-Identifier: BSD-3-Clause
// Bags and videos that others' writers made, through the real program.
#include <cmath>
#include <filesystem>
#include <fstream>

#include <nlohmann/json.hpp>

#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"
#include "tests/system/made_recording.h"
#include "tests/system/peers.h"

namespace cliquevo::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kPairs = 12;

std::string trajectory_of(const std::string& source, std::vector<std::string> options = {}) {
  const std::string path = scratch_dir() + "/trajectory.txt";
  fs::remove(path);
  options.insert(options.begin(), {binary("cliquevo"), "replay", source, "--trajectory", path});
  const Finished done = run(options);
  EXPECT_EQ(done.exit_code, 0) << done.err;
  return read_file(path);
}

// The folder that everything is made from, and its trajectory.
struct Original {
  std::string folder = made_recording(kPairs);
  std::string trajectory = trajectory_of(folder);
};
const Original& original() {
  static const Original made;
  return made;
}

std::string bag(const std::string& name, const std::string& option = "none") {
  const std::string out = scratch_dir() + "/" + name;
  fs::remove(out);
  run_peer("write_bag.py", {original().folder, out, option});
  return out;
}

std::string mcap(const std::string& name, const std::string& option) {
  const std::string out = scratch_dir() + "/" + name;
  fs::remove(out);
  run_peer("write_mcap.mjs", {bag("messages.jsonl"), out, option});
  return out;
}

// One line, with exit code 1.
void expect_refused(const std::string& source, const std::string& text) {
  const Finished done = run({binary("cliquevo"), "replay", source});
  EXPECT_EQ(done.exit_code, 1) << source;
  EXPECT_EQ(lines_of(done.err).size(), 1u) << done.err;
  EXPECT_NE(done.err.find(text), std::string::npos) << done.err;
}

TEST(Bags, ABagOfRos1ReplaysToTheTrajectoryOfItsFolder) {
  for (const char* compression : {"none", "bz2", "lz4"}) {
    EXPECT_EQ(trajectory_of(bag("a.bag", compression)), original().trajectory) << compression;
  }
}

TEST(Bags, AnMcapReplaysToTheTrajectoryOfItsFolder) {
  for (const char* form : {"none", "zstd", "lz4", "unchunked"}) {
    EXPECT_EQ(trajectory_of(mcap("a.mcap", form)), original().trajectory) << form;
  }
}

TEST(Bags, ADatabaseOfRosbag2ReplaysToTheTrajectoryOfItsFolder) {
  const std::string database = bag("a.db3");
  EXPECT_EQ(trajectory_of(database), original().trajectory);
  // As rosbag2 has it: a folder with the database and what describes it.
  const std::string folder = scratch_dir() + "/rosbag2";
  fs::create_directories(folder);
  fs::copy_file(database, folder + "/a_0.db3");
  std::ofstream(folder + "/metadata.yaml")
      << "rosbag2_bagfile_information:\n  version: 5\n  storage_identifier: sqlite3\n";
  EXPECT_EQ(trajectory_of(folder), original().trajectory);
}

TEST(Bags, HeaderStampsAreTakenNotThoseOfArrival) {
  // Arrivals are 7 ms later.
  EXPECT_EQ(trajectory_of(bag("a.bag"), {"--format", "tum"}), trajectory_of(original().folder, {"--format", "tum"}));
}

TEST(Bags, TopicsCanBeNamedAndWrongOnesAreRefused) {
  const std::string path = bag("a.bag");
  const std::string l = "/stereo/left/image_raw";
  const std::string r = "/stereo/right/image_raw";
  EXPECT_EQ(trajectory_of(path, {"--topics", l + "," + r}), original().trajectory);
  const std::string info = ",/stereo/left/camera_info,/stereo/right/camera_info";
  EXPECT_EQ(trajectory_of(path, {"--topics", l + "," + r + info}), original().trajectory);
  const Finished wrong = run({binary("cliquevo"), "replay", path, "--topics", l + ",/nobody"});
  EXPECT_EQ(wrong.exit_code, 1);
  EXPECT_NE(wrong.err.find("/stereo/right/image_raw (sensor_msgs/Image, 12)"), std::string::npos) << wrong.err;
}

TEST(Bags, APartOfABagIsTheSamePartOfItsFolder) {
  const std::vector<std::string> part{"--first", "4", "--last", "9"};
  EXPECT_EQ(trajectory_of(mcap("a.mcap", "zstd"), part), trajectory_of(original().folder, part));
}

TEST(Bags, ATornBagPlaysUpToItsLastWholeMessage) {
  for (const std::string& path : {bag("torn.bag", "none"), bag("torn_lz4.bag", "lz4"), mcap("torn.mcap", "zstd"),
                                  mcap("torn_plain.mcap", "none"), mcap("torn_unchunked.mcap", "unchunked")}) {
    fs::resize_file(path, fs::file_size(path) * 2 / 3);
    const std::string played = trajectory_of(path);
    EXPECT_EQ(original().trajectory.substr(0, played.size()), played) << path;
    const std::size_t pairs = lines_of(played).size();
    EXPECT_GE(pairs, 6u) << path;
    EXPECT_LT(pairs, static_cast<std::size_t>(kPairs)) << path;
    const Finished said = run({binary("cliquevo"), "info", path});
    EXPECT_NE(said.out.find("cut off"), std::string::npos) << said.out;
  }
}

TEST(Bags, WhatIsNoStereoBagIsRefusedInALine) {
  const std::string path = scratch_dir() + "/empty.mcap";
  std::ofstream(path, std::ios::binary) << "\x89MCAP0\r\n";
  expect_refused(path, "bag has no message");
  const std::string old = scratch_dir() + "/old.bag";
  std::ofstream(old, std::ios::binary) << "#ROSBAG V1.2\n";
  expect_refused(old, "another version than 2.0");
}

TEST(Bags, InfoTellsStreamsAndWhatWouldBePlayed) {
  const Finished done = run({binary("cliquevo"), "info", bag("a.bag", "lz4"), "--json"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const json page = json::parse(done.out);
  EXPECT_EQ(page["kind"], "ROS 1 bag");
  ASSERT_EQ(page["streams"].size(), 4u);
  for (const json& stream : page["streams"]) {
    EXPECT_EQ(stream["count"], kPairs);
    EXPECT_EQ(stream["gaps"], 0);
    EXPECT_NEAR(stream["rate_hz"].get<double>(), page["played"]["rate_hz"].get<double>(), 0.01);
  }
  EXPECT_EQ(page["played"]["pairs"], kPairs);
  EXPECT_EQ(page["played"]["width"], 320);
  EXPECT_GT(page["played"]["calibration"]["rectified"]["baseline_m"].get<double>(), 0.05);
}

TEST(Bags, InfoTellsOfEveryKindOfSource) {
  const std::string log = scratch_dir() + "/a.lcm";
  ASSERT_EQ(run({binary("cliquevo"), "convert", bag("a.db3"), log}).exit_code, 0);
  for (const std::string& source :
       {original().folder, log, std::string("sim:frames=3,width=320,height=240,cache_dir=none")}) {
    const Finished done = run({binary("cliquevo"), "info", source, "--json"});
    EXPECT_EQ(done.exit_code, 0) << done.err;
    EXPECT_GT(json::parse(done.out)["played"]["pairs"].get<int>(), 0) << source;
  }
  EXPECT_EQ(trajectory_of(log), original().trajectory);
}

// ---- videos ---------------------------------------------------------------------------------------------------------

// Both cameras' images side by side, by ffmpeg; its frames come at the recording's rate.
std::string video(const std::string& name, const std::vector<std::string>& codec) {
  const std::string out = scratch_dir() + "/" + name;
  std::vector<std::string> command{"ffmpeg", "-v", "error", "-y"};
  for (const char* side : {"0", "1"}) {
    command.insert(command.end(), {"-framerate", "30", "-i", original().folder + "/image_" + side + "/%06d.png"});
  }
  command.insert(command.end(), {"-filter_complex", "hstack"});
  command.insert(command.end(), codec.begin(), codec.end());
  command.push_back(out);
  const Finished done = run(command);
  EXPECT_EQ(done.exit_code, 0) << done.err;
  return out;
}

std::vector<std::string> with_calibration() { return {"--calibration", original().folder + "/calib.txt"}; }

TEST(Videos, LosslessOnesReplayToTheTrajectoryOfTheirFolder) {
  for (const auto& [name, codec] : std::vector<std::pair<std::string, std::vector<std::string>>>{
           {"a.mkv", {"-c:v", "ffv1", "-pix_fmt", "gray"}},
           {"b.avi", {"-c:v", "ffv1", "-pix_fmt", "gray"}},
           {"c.mov", {"-c:v", "png", "-pix_fmt", "gray"}},
           {"d.mp4", {"-c:v", "libx264", "-qp", "0", "-bf", "2", "-pix_fmt", "yuvj420p"}}}) {
    std::vector<std::string> options = with_calibration();
    options.insert(options.end(), {"--rate", "30"});
    EXPECT_EQ(trajectory_of(video(name, codec), options), trajectory_of(original().folder, {"--rate", "30"})) << name;
  }
}

// Largest distance between the positions of two trajectories [m].
double apart(const std::string& a, const std::string& b) {
  const auto rows_a = lines_of(a);
  const auto rows_b = lines_of(b);
  EXPECT_EQ(rows_a.size(), rows_b.size());
  double most = 0.0;
  for (std::size_t i = 0; i < std::min(rows_a.size(), rows_b.size()); ++i) {
    std::istringstream in_a(rows_a[i]);
    std::istringstream in_b(rows_b[i]);
    double sum = 0.0;
    for (int k = 0; k < 12; ++k) {
      double u = 0.0;
      double v = 0.0;
      in_a >> u;
      in_b >> v;
      if (k % 4 == 3) sum += (u - v) * (u - v);
    }
    most = std::max(most, std::sqrt(sum));
  }
  return most;
}

TEST(Videos, CompressedOnesReplayNearlySo) {
  for (const auto& [name, codec] : std::vector<std::pair<std::string, std::vector<std::string>>>{
           {"a.mp4", {"-c:v", "libx264", "-crf", "12", "-bf", "2", "-pix_fmt", "yuv420p"}},
           {"b.mkv", {"-c:v", "libx265", "-crf", "12", "-x265-params", "log-level=error", "-pix_fmt", "yuv420p"}},
           {"c.avi", {"-c:v", "mjpeg", "-q:v", "2", "-pix_fmt", "yuvj420p"}}}) {
    // 1.1 m of way: two per cent.
    EXPECT_LT(apart(trajectory_of(video(name, codec), with_calibration()), original().trajectory), 0.022) << name;
  }
}

TEST(Videos, OneFileACameraReplaysLikeSideBySide) {
  const std::string folder = scratch_dir() + "/two";
  fs::create_directories(folder);
  for (const auto& [side, name] : {std::pair{"0", "left"}, std::pair{"1", "right"}}) {
    ASSERT_EQ(run({"ffmpeg", "-v", "error", "-y", "-framerate", "30", "-i",
                   original().folder + "/image_" + side + "/%06d.png", "-c:v", "ffv1", "-pix_fmt", "gray",
                   folder + "/" + name + ".mkv"})
                  .exit_code,
              0);
  }
  const std::string wanted = trajectory_of(original().folder, {"--rate", "30"});
  std::vector<std::string> options = with_calibration();
  options.insert(options.end(), {"--rate", "30"});
  EXPECT_EQ(trajectory_of(folder, options), wanted);
  EXPECT_EQ(trajectory_of(folder + "/left.mkv," + folder + "/right.mkv", options), wanted);
}

TEST(Videos, AnyPartPlaysAlsoBackward) {
  const std::string path = video("a.mp4", {"-c:v", "libx264", "-qp", "0", "-bf", "2", "-pix_fmt", "yuvj420p"});
  std::vector<std::string> options = with_calibration();
  options.insert(options.end(), {"--rate", "30", "--first", "5", "--every", "2"});
  EXPECT_EQ(trajectory_of(path, options),
            trajectory_of(original().folder, {"--rate", "30", "--first", "5", "--every", "2"}));
}

TEST(Videos, TornAndForeignFilesAreRefusedInALine) {
  const std::string path = video("torn.mp4", {"-c:v", "libx264", "-pix_fmt", "gray"});
  fs::resize_file(path, fs::file_size(path) / 2);
  expect_refused(path, "cannot open video");
  const std::string list = scratch_dir() + "/list.mkv";
  std::ofstream(list) << "ffconcat version 1.0\nfile /etc/hostname\n";
  expect_refused(list, "cannot open video");
}

}  // namespace
}  // namespace cliquevo::test
