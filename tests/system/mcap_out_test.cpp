// SPDX-License-Identifier: BSD-3-Clause
// MCAPs that cliquevo writes, read by others' code to the bit.
#include <csignal>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <map>
#include <string>
#include <thread>
#include <vector>

#include <cliquevo/odometry_t.hpp>
#include <cliquevo/points_t.hpp>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "drivers/recorder.h"
#include "drivers/recording.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"
#include "tests/system/made_recording.h"
#include "tests/system/peers.h"

namespace cliquevo::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr int kPairs = 8;

odometry_t odometry_at(TimestampNs stamp_ns, int n) {
  odometry_t m{};
  m.utime = stamp_ns / 1000;
  m.orientation[0] = 0.6;
  m.orientation[2] = 0.8;
  for (int i = 0; i < 3; ++i) {
    m.position[i] = 0.1 * n + i / 3.0;
    m.velocity[i] = n - i / 7.0;
    m.rotation_rate[i] = n / 11.0 + i;
  }
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) {
      m.pose_covariance[r][c] = 1.0 / (1 + r + c + n);
      m.twist_covariance[r][c] = 1.0 / (3 + r * c + n);
    }
  }
  m.quality = 77;
  m.status = 1;
  m.reset_counter = 5;
  return m;
}

points_t points_at(TimestampNs stamp_ns, int n) {
  points_t m{};
  m.utime = stamp_ns / 1000;
  m.step_px = 4;
  m.num_points = 3 + n;
  for (int i = 0; i < m.num_points; ++i) {
    m.x.push_back(1.0F + static_cast<float>(i) / 7.0F);
    m.y.push_back(static_cast<float>(n) - static_cast<float>(i) / 3.0F);
    m.z.push_back(-0.1F * static_cast<float>(i));
    m.sigma.push_back(0.01F * static_cast<float>(1 + i));
    m.grey.push_back(static_cast<std::uint8_t>(200 + i));
  }
  return m;
}

template <typename Message>
void add(const std::string& channel, const Message& m, drivers::Recorder& recorder) {
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(m.getEncodedSize()));
  m.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  recorder.add(channel, bytes.data(), bytes.size(), m.utime);
}

struct Original {
  std::vector<drivers::StereoPair> pairs;
  StereoModel model;
  std::string log;
};

// A log with pairs, calibration and odometry, as the daemon's recording has them.
Original made_log() {
  Original out;
  drivers::RecordingOptions options;
  options.path = made_recording(kPairs);
  auto source = drivers::open_recording(options);
  EXPECT_TRUE(source.ok());
  out.model = (*source)->info().calibration.prescribed->model;
  drivers::RecorderOptions recorder_options;
  out.log = scratch_dir() + "/made.lcm";
  recorder_options.path = out.log;
  recorder_options.wait_when_full = true;
  auto recorder = drivers::Recorder::start(recorder_options, (*source)->info());
  EXPECT_TRUE(recorder.ok());
  for (int n = 0;; ++n) {
    drivers::StereoPair pair;
    const auto more = (*source)->next(pair);
    if (!more.ok() || !*more) break;
    recorder->add(pair, pair.stamp_ns / 1000);
    add("VO_ODOMETRY", odometry_at(pair.stamp_ns, n), *recorder);
    add("VO_POINTS", points_at(pair.stamp_ns, n), *recorder);
    out.pairs.push_back(std::move(pair));
  }
  EXPECT_TRUE(recorder->stop().ok());
  EXPECT_EQ(out.pairs.size(), static_cast<std::size_t>(kPairs));
  return out;
}

using Topics = std::map<std::string, std::vector<json>>;
Topics read_by_others(const std::string& path) {
  Topics out;
  for (const std::string& line : lines_of(run_peer("read_mcap.mjs", {path}).out)) {
    const json m = json::parse(line);
    out[m["topic"]].push_back(m);
  }
  return out;
}

std::string base64(ImageView<const std::uint8_t> image) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  for (int y = 0; y < image.height; ++y)
    bytes.append(reinterpret_cast<const char*>(image.row(y)), static_cast<std::size_t>(image.width));
  std::string out;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    unsigned bits = 0;
    for (std::size_t k = 0; k < 3; ++k)
      bits = bits << 8U | (i + k < bytes.size() ? static_cast<std::uint8_t>(bytes[i + k]) : 0U);
    for (std::size_t k = 0; k < 4; ++k) out += i + k > bytes.size() ? '=' : kDigits[bits >> (18 - 6 * k) & 63U];
  }
  return out;
}

void expect_stamp(const json& header, TimestampNs stamp_ns) {
  EXPECT_EQ(header["stamp"]["sec"].get<std::int64_t>() * 1'000'000'000 + header["stamp"]["nanosec"].get<std::int64_t>(),
            stamp_ns);
}

void expect_images(const Topics& topics, const Original& original, bool left) {
  const std::string camera = left ? "/stereo/left" : "/stereo/right";
  const auto& images = topics.at(camera + "/image_rect");
  const auto& infos = topics.at(camera + "/camera_info");
  ASSERT_EQ(images.size(), original.pairs.size());
  ASSERT_EQ(infos.size(), original.pairs.size());
  for (std::size_t i = 0; i < images.size(); ++i) {
    const drivers::StereoPair& pair = original.pairs[i];
    const json& m = images[i]["message"];
    expect_stamp(m["header"], pair.stamp_ns);
    EXPECT_EQ(m["encoding"], "mono8");
    EXPECT_EQ(m["width"], pair.left.width());
    EXPECT_EQ(m["height"], pair.left.height());
    EXPECT_EQ(m["step"], pair.left.width());
    EXPECT_EQ(m["data"], base64(left ? pair.left.cview() : pair.right.cview()));
    const json& info = infos[i]["message"];
    expect_stamp(info["header"], pair.stamp_ns);
    const StereoModel& c = original.model;
    EXPECT_EQ(info["p"][0].get<double>(), c.fx_px);
    EXPECT_EQ(info["p"][2].get<double>(), left ? c.cx_px : c.cx_px + c.doffs_px);
    EXPECT_EQ(info["p"][3].get<double>(), left ? 0.0 : -c.fx_px * c.baseline_m);
    EXPECT_EQ(info["p"][6].get<double>(), c.cy_px);
    EXPECT_EQ(info["k"][4].get<double>(), c.fy_px);
    EXPECT_EQ(info["d"], json({0.0, 0.0, 0.0, 0.0, 0.0}));
    EXPECT_EQ(info["r"], json({1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0}));
  }
}

void expect_odometry(const Topics& topics, const Original& original) {
  const auto& odom = topics.at("/odom");
  ASSERT_EQ(odom.size(), original.pairs.size());
  ASSERT_EQ(topics.at("/tf").size(), original.pairs.size());
  ASSERT_EQ(topics.at("/diagnostics").size(), original.pairs.size());
  for (std::size_t n = 0; n < odom.size(); ++n) {
    const odometry_t m = odometry_at(original.pairs[n].stamp_ns, static_cast<int>(n));
    const json& o = odom[n]["message"];
    expect_stamp(o["header"], m.utime * 1000);
    EXPECT_EQ(o["header"]["frame_id"], "odom");
    EXPECT_EQ(o["child_frame_id"], "base_link");
    const char* axes[3] = {"x", "y", "z"};
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(o["pose"]["pose"]["position"][axes[i]].get<double>(), m.position[i]);
      EXPECT_EQ(o["twist"]["twist"]["linear"][axes[i]].get<double>(), m.velocity[i]);
      EXPECT_EQ(o["twist"]["twist"]["angular"][axes[i]].get<double>(), m.rotation_rate[i]);
      EXPECT_EQ(o["pose"]["pose"]["orientation"][axes[i]].get<double>(), m.orientation[i + 1]);
    }
    EXPECT_EQ(o["pose"]["pose"]["orientation"]["w"].get<double>(), m.orientation[0]);
    for (std::size_t k = 0; k < 36; ++k) {
      EXPECT_EQ(o["pose"]["covariance"][k].get<double>(), m.pose_covariance[k / 6][k % 6]);
      EXPECT_EQ(o["twist"]["covariance"][k].get<double>(), m.twist_covariance[k / 6][k % 6]);
    }
    const json& tf = topics.at("/tf")[n]["message"]["transforms"][0];
    EXPECT_EQ(tf["child_frame_id"], "base_link");
    EXPECT_EQ(tf["transform"]["translation"]["x"].get<double>(), m.position[0]);
    const json& status = topics.at("/diagnostics")[n]["message"]["status"][0];
    EXPECT_EQ(status["level"], 0);
    EXPECT_EQ(status["message"], "valid");
    EXPECT_EQ(status["values"][0]["value"], "77");
  }
  EXPECT_EQ(topics.at("/tf_static").size(), 1u);
  const json& path = topics.at("/path").back()["message"];
  EXPECT_EQ(path["width"], kPairs);
  EXPECT_EQ(path["point_step"], 12);
}

// The bytes of a base64 text.
std::string bytes_of(const std::string& text) {
  static const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  unsigned bits = 0;
  int count = 0;
  for (const char c : text) {
    if (c == '=') break;
    bits = bits << 6U | static_cast<unsigned>(digits.find(c));
    count += 6;
    if (count < 8) continue;
    count -= 8;
    out += static_cast<char>(bits >> static_cast<unsigned>(count) & 255U);
  }
  return out;
}

void expect_points(const Topics& topics, const Original& original) {
  const auto& clouds = topics.at("/stereo/points2");
  ASSERT_EQ(clouds.size(), original.pairs.size());
  for (std::size_t n = 0; n < clouds.size(); ++n) {
    const points_t m = points_at(original.pairs[n].stamp_ns, static_cast<int>(n));
    const json& cloud = clouds[n]["message"];
    expect_stamp(cloud["header"], m.utime * 1000);
    EXPECT_EQ(cloud["header"]["frame_id"], "base_link");
    EXPECT_EQ(cloud["height"], 1);
    ASSERT_EQ(cloud["width"], m.num_points);
    EXPECT_EQ(cloud["point_step"], 20);
    EXPECT_EQ(cloud["row_step"], 20 * m.num_points);
    EXPECT_EQ(cloud["is_dense"], true);
    const char* names[5] = {"x", "y", "z", "sigma", "intensity"};
    ASSERT_EQ(cloud["fields"].size(), 5U);
    for (std::size_t k = 0; k < 5; ++k) {
      EXPECT_EQ(cloud["fields"][k]["name"], names[k]);
      EXPECT_EQ(cloud["fields"][k]["offset"], 4 * k);
      EXPECT_EQ(cloud["fields"][k]["datatype"], 7);
    }
    const std::string data = bytes_of(cloud["data"]);
    ASSERT_EQ(data.size(), 20U * static_cast<std::size_t>(m.num_points));
    for (std::size_t i = 0; i < m.x.size(); ++i) {
      float values[5];
      std::memcpy(values, data.data() + 20 * i, sizeof values);
      const float expected[5] = {m.x[i], m.y[i], m.z[i], m.sigma[i], static_cast<float>(m.grey[i])};
      for (int k = 0; k < 5; ++k) EXPECT_EQ(values[k], expected[k]);
    }
  }
}

TEST(McapOut, ImagesAsPngAreTheSameToTheBitAndPlayAlike) {
  const Original original = made_log();
  const std::string out = scratch_dir() + "/png.mcap";
  const Finished done = run({binary("cliquevo"), "convert", original.log, out, "--png"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const Topics topics = read_by_others(out);
  EXPECT_FALSE(topics.contains("/stereo/left/image_rect"));
  for (const bool left : {true, false}) {
    const auto& images = topics.at(left ? "/stereo/left/image_rect/compressed" : "/stereo/right/image_rect/compressed");
    ASSERT_EQ(images.size(), original.pairs.size());
    for (std::size_t i = 0; i < images.size(); ++i) {
      const json& m = images[i]["message"];
      expect_stamp(m["header"], original.pairs[i].stamp_ns);
      EXPECT_EQ(m["format"], "png");
      const std::string file = bytes_of(m["data"]);
      const cv::Mat decoded = cv::imdecode(std::vector<unsigned char>(file.begin(), file.end()), cv::IMREAD_UNCHANGED);
      ASSERT_EQ(decoded.type(), CV_8UC1);
      const auto& image = left ? original.pairs[i].left : original.pairs[i].right;
      const cv::Mat sent(image.height(), image.width(), CV_8UC1, const_cast<std::uint8_t*>(image.cview().data),
                         static_cast<std::size_t>(image.cview().stride));
      EXPECT_EQ(cv::norm(decoded, sent, cv::NORM_INF), 0.0);
    }
  }
  std::string ways[2];
  for (const bool png : {false, true}) {
    const std::string file = scratch_dir() + "/way.txt";
    const Finished played = run({binary("cliquevo"), "replay", png ? out : original.log, "--trajectory", file});
    ASSERT_EQ(played.exit_code, 0) << played.err;
    ways[png ? 1 : 0] = read_file(file);
  }
  EXPECT_EQ(ways[0], ways[1]);
}

TEST(McapOut, PngIsForMcapsAlone) {
  const Finished done = run({binary("cliquevo"), "convert", "sim:frames=2", scratch_dir() + "/log.lcm", "--png"});
  EXPECT_EQ(done.exit_code, 2);
  EXPECT_NE(done.err.find("--to mcap"), std::string::npos) << done.err;
}

TEST(McapOut, AConvertedLogIsReadByOthersToTheBit) {
  const Original original = made_log();
  const std::string out = scratch_dir() + "/out.mcap";
  const Finished done = run({binary("cliquevo"), "convert", original.log, out});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const Topics topics = read_by_others(out);
  expect_images(topics, original, true);
  expect_images(topics, original, false);
  expect_odometry(topics, original);
  expect_points(topics, original);
}

TEST(McapOut, ARecordedOneHoldsEveryPairAndIsNotOverwritten) {
  const Original original = made_log();
  const std::string out = scratch_dir() + "/recorded.mcap";
  ASSERT_EQ(run({binary("cliquevo"), "record", original.log, "--out", out}).exit_code, 0);
  expect_images(read_by_others(out), original, true);
  const Finished again = run({binary("cliquevo"), "record", original.log, "--out", out});
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_NE(again.err.find("it is there already"), std::string::npos) << again.err;
}

TEST(McapOut, WhatAKilledWriterLeftIsPlayed) {
  const std::string out = scratch_dir() + "/killed.mcap";
  Subprocess writer(
      {binary("cliquevo"), "record", "sim:frames=2000,width=320,height=240,cache_dir=none", "--out", out});
  for (int i = 0; i < 2400 && (!fs::exists(out) || fs::file_size(out) < 4'000'000); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  writer.send(SIGKILL);
  writer.wait();
  const Finished said = run({binary("cliquevo"), "info", out, "--json"});
  ASSERT_EQ(said.exit_code, 0) << said.err;
  EXPECT_GE(json::parse(said.out)["played"]["pairs"].get<int>(), 15);
}

}  // namespace
}  // namespace cliquevo::test
