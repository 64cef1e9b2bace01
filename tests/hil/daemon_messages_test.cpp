// SPDX-License-Identifier: BSD-3-Clause
// What an independent program receives from the daemon: LCM's own library, types from definitions of their own, over
// real multicast.
#include <atomic>
#include <bot_core/images_t.hpp>
#include <bot_core/pose_t.hpp>
#include <chrono>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fovis/update_t.hpp>
#include <fstream>
#include <thread>
#include <vector>

#include <cliquevo/command_t.hpp>
#include <cliquevo/health_t.hpp>
#include <cliquevo/movers_t.hpp>
#include <cliquevo/status_t.hpp>
#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>

#include "daemon/pipeline/trajectory_file.h"
#include "tests/hil/private_network.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo {
namespace {

constexpr const char* kCommands = "lcm: {command_channel: VO_COMMAND}\n";
constexpr const char* kUrl = "udpm://239.255.76.67:7667?ttl=0";

class Subscriber {
 public:
  Subscriber() : lcm_(kUrl) {
    EXPECT_TRUE(lcm_.good());
    lcm_.subscribe("VO_DELTA_CAMERA", &Subscriber::on_delta, this)->setQueueCapacity(10'000);
    lcm_.subscribe("POSE_BODY", &Subscriber::on_pose, this)->setQueueCapacity(10'000);
    lcm_.subscribe("VO_STATUS", &Subscriber::on_status, this)->setQueueCapacity(10'000);
    lcm_.subscribe("VO_HEALTH", &Subscriber::on_health, this)->setQueueCapacity(10'000);
    thread_ = std::thread([this] {
      while (!stop_) lcm_.handleTimeout(20);
    });
  }
  ~Subscriber() { finish(); }

  // Handles what is still there, then stops.
  void finish() {
    if (!thread_.joinable()) return;
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    stop_ = true;
    thread_.join();
  }
  // After finish(), but for the counters.
  std::vector<fovis::update_t> deltas;
  std::vector<bot_core::pose_t> poses;
  std::vector<status_t> statuses;
  std::vector<health_t> healths;
  std::atomic<int> statuses_seen{0};
  std::atomic<int> healths_seen{0};
  std::atomic<int> resets_seen{0};
  std::atomic<bool> recording{false};  // as the last health says

 private:
  void on_delta(const lcm::ReceiveBuffer*, const std::string&, const fovis::update_t* m) { deltas.push_back(*m); }
  void on_pose(const lcm::ReceiveBuffer*, const std::string&, const bot_core::pose_t* m) { poses.push_back(*m); }
  void on_status(const lcm::ReceiveBuffer*, const std::string&, const status_t* m) {
    statuses.push_back(*m);
    ++statuses_seen;
    resets_seen = m->resets;
  }
  void on_health(const lcm::ReceiveBuffer*, const std::string&, const health_t* m) {
    healths.push_back(*m);
    recording = m->recording_text.rfind("recording, ", 0) == 0;
    ++healths_seen;
  }

  lcm::LCM lcm_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

struct StereoCount {
  int images = 0;
  int width = 0;
  void on_images(const lcm::ReceiveBuffer*, const std::string&, const bot_core::images_t* m) {
    ++images;
    width = m->n_images == 2 ? m->images[0].width : 0;
  }
};

bool all_finite(const double* values, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i) {
    if (!std::isfinite(values[i])) return false;
  }
  return true;
}

// One message of each kind a frame, of the same instants, in order, every number finite.
void expect_one_of_each(const Subscriber& got, std::size_t frames) {
  ASSERT_EQ(got.deltas.size(), frames);
  ASSERT_EQ(got.poses.size(), frames);
  ASSERT_EQ(got.statuses.size(), frames);
  std::int64_t last_valid_utime = 0;
  for (std::size_t i = 0; i < frames; ++i) {
    const fovis::update_t& delta = got.deltas[i];
    const bot_core::pose_t& pose = got.poses[i];
    const status_t& status = got.statuses[i];
    EXPECT_EQ(delta.timestamp, status.utime);
    EXPECT_EQ(pose.utime, status.utime);
    if (i > 0) {
      EXPECT_GT(status.utime, got.statuses[i - 1].utime);
      EXPECT_GT(status.frame, got.statuses[i - 1].frame);
      EXPECT_EQ(delta.prev_timestamp, last_valid_utime);
    }
    EXPECT_TRUE(all_finite(delta.translation, 3) && all_finite(delta.rotation, 4));
    EXPECT_TRUE(all_finite(&delta.covariance[0][0], 36));
    EXPECT_TRUE(all_finite(pose.pos, 3) && all_finite(pose.vel, 3) && all_finite(pose.orientation, 4));
    EXPECT_TRUE(all_finite(pose.rotation_rate, 3) && all_finite(pose.accel, 3));
    EXPECT_TRUE(std::isfinite(status.reprojection_error_px) && std::isfinite(status.eigenvalue_ratio));
    EXPECT_EQ(status.repaired, 0);
    EXPECT_LE(status.grabbed_utime, status.stereo_begin_utime);
    EXPECT_LE(status.stereo_begin_utime, status.stereo_end_utime);
    EXPECT_LE(status.stereo_end_utime, status.odometry_begin_utime);
    EXPECT_LE(status.odometry_begin_utime, status.odometry_end_utime);
    EXPECT_LE(status.odometry_end_utime, status.publish_utime);
    if (i == 0 || delta.estimate_status == 1) last_valid_utime = delta.timestamp;
  }
}

std::string write_config(const std::string& dir, const std::string& text) {
  const std::string path = dir + "/config.yaml";
  std::ofstream(path) << text;
  return path;
}

std::string small_course(int frames, double speed, const char* loop) {
  return "source:\n  type: simulator\n  speed: " + std::to_string(speed) + "\n  loop: " + loop +
         "\n  simulator: {width: 256, height: 192, focal_px: 280, frames: " + std::to_string(frames) +
         ", cache_dir: none}\nstereo: {num_disparities: 48}\n";
}

TEST(DaemonMessages, ASubscriberReceivesOneOfEachForEveryFrameInOrderAndNoneNan) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  Subscriber subscriber;
  const std::string dir = test::scratch_dir();
  test::Subprocess daemon({test::binary("cliquevod"), "--config", write_config(dir, small_course(25, 0.0, "none"))});
  const test::Finished end = daemon.wait();
  EXPECT_EQ(end.exit_code, 0) << end.err;
  subscriber.finish();
  expect_one_of_each(subscriber, 25);
  EXPECT_EQ(subscriber.statuses.front().status, status_t::NO_DATA);
  int valid = 0;
  for (const status_t& status : subscriber.statuses) valid += status.status == status_t::VALID ? 1 : 0;
  EXPECT_EQ(valid, 24);
  EXPECT_EQ(subscriber.statuses.back().frame, 24);
  EXPECT_GT(subscriber.poses.back().pos[0], 1.0) << "the course goes forward, which is the body's x";
}

TEST(DaemonMessages, ARecordingArrivesCompletelyAndAgreesWithItsTrajectory) {
  CLIQUEVO_NEEDS_DATA("kitti_odometry_06");
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  Subscriber subscriber;
  const std::string dir = test::scratch_dir();
  const std::string config =
      write_config(dir, "source:\n  type: recording\n  speed: 0\n  recording: {path: " + test::data_dir() +
                            "/kitti_odometry_06, last: 19}\n");
  test::Subprocess daemon({test::binary("cliquevod"), "--config", config, "--trajectory", dir + "/trajectory.txt"});
  const test::Finished end = daemon.wait();
  EXPECT_EQ(end.exit_code, 0) << end.err;
  subscriber.finish();
  expect_one_of_each(subscriber, 20);
  const auto trajectory = daemon::read_trajectory(dir + "/trajectory.txt");
  ASSERT_TRUE(trajectory.ok());
  ASSERT_EQ(trajectory->poses.size(), 20u);
  for (std::size_t i = 0; i < 20; ++i) {
    // The camera looks forward from the body's origin: z is the body's x, x its -y, y its -z.
    const Eigen::Vector3d t = trajectory->poses[i].T_world_camera.t;
    const double(&pos)[3] = subscriber.poses[i].pos;
    EXPECT_NEAR((Eigen::Vector3d(pos[0], pos[1], pos[2]) - Eigen::Vector3d(t.z(), -t.x(), -t.y())).norm(), 0.0, 1e-9);
  }
}

TEST(DaemonMessages, MoversAreSentForEveryFrameWhenAskedFor) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  lcm::LCM lcm(kUrl);
  struct Collector {
    std::vector<movers_t> movers;
    std::vector<status_t> statuses;
    void on_movers(const lcm::ReceiveBuffer*, const std::string&, const movers_t* m) { movers.push_back(*m); }
    void on_status(const lcm::ReceiveBuffer*, const std::string&, const status_t* m) { statuses.push_back(*m); }
  } collector;
  lcm.subscribe("VO_MOVERS", &Collector::on_movers, &collector)->setQueueCapacity(1000);
  lcm.subscribe("VO_STATUS", &Collector::on_status, &collector)->setQueueCapacity(1000);
  const std::string config =
      "source: {speed: 0, simulator: {frames: 90, movers: 3}}\nlcm: {movers_channel: VO_MOVERS}\n";
  test::Subprocess daemon({test::binary("cliquevod"), "--config", write_config(test::scratch_dir(), config)});
  for (int timeout_ms = 120'000; lcm.handleTimeout(timeout_ms) > 0; timeout_ms = 3000) {
  }
  EXPECT_EQ(daemon.wait().exit_code, 0);
  ASSERT_EQ(collector.movers.size(), 90U);
  ASSERT_EQ(collector.statuses.size(), 90U);
  int reported = 0;
  for (std::size_t i = 0; i < collector.movers.size(); ++i) {
    const movers_t& m = collector.movers[i];
    EXPECT_EQ(m.utime, collector.statuses[i].utime);
    if (collector.statuses[i].status != status_t::VALID) {
      EXPECT_EQ(m.num_movers, 0) << "frame " << i;
    }
    for (const mover_t& thing : m.movers) {
      ++reported;
      EXPECT_GE(thing.frames, 3);
      EXPECT_GE(thing.inliers, 6);
      EXPECT_EQ(thing.of_vehicle, 0);
      EXPECT_GT(thing.centre[2], 1.0) << "the boxes drive some metres ahead";
      EXPECT_LT(thing.centre[2], 12.0);
      ASSERT_EQ(thing.pixel.size(), static_cast<std::size_t>(thing.num_points));
      for (const auto& pixel : thing.pixel) {
        EXPECT_TRUE(pixel[0] >= 0 && pixel[0] < 512 && pixel[1] >= 0 && pixel[1] < 384);
      }
    }
  }
  EXPECT_GT(reported, 5) << "three boxes cross the view";
}

TEST(DaemonMessages, ImagesAreSentWhenAskedForAndAtTheirRate) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  lcm::LCM lcm(kUrl);
  struct Collector {
    std::vector<bot_core::images_t> seen;
    void on_images(const lcm::ReceiveBuffer*, const std::string&, const bot_core::images_t* m) { seen.push_back(*m); }
  } collector;
  lcm.subscribe("VO_IMAGES", &Collector::on_images, &collector)->setQueueCapacity(100);
  const char* asked = "lcm: {images_channel: VO_IMAGES, images_rate_hz: 10, images_right: true}\n";
  const std::string config = write_config(test::scratch_dir(), small_course(30, 1.0, "none") + asked);
  test::Subprocess daemon({test::binary("cliquevod"), "--config", config});
  for (int timeout_ms = 60'000; lcm.handleTimeout(timeout_ms) > 0; timeout_ms = 3000) {
  }
  EXPECT_EQ(daemon.wait().exit_code, 0);
  const auto& seen = collector.seen;
  ASSERT_GE(seen.size(), 2U);
  EXPECT_LE(seen.size(), 11U) << "a second of frames";
  const bot_core::images_t& images = seen.back();
  using bot_core::images_t;
  EXPECT_EQ(images.image_types, (std::vector<std::int16_t>{images_t::LEFT, images_t::DISPARITY, images_t::RIGHT}));
  const bot_core::image_t& disparity = images.images[1];
  ASSERT_EQ(disparity.width, 256);
  ASSERT_EQ(disparity.height, 192);
  ASSERT_EQ(disparity.data.size(), 256U * 192U * 2U);
  ASSERT_EQ(images.images[0].data.size(), 256U * 192U);
  ASSERT_EQ(images.images[2].data.size(), 256U * 192U);
  EXPECT_NE(images.images[2].data, images.images[0].data);
  std::size_t known = 0;
  for (std::size_t i = 0; i < disparity.data.size(); i += 2) {
    const int value = disparity.data[i] | disparity.data[i + 1] << 8;
    EXPECT_LT(value, 48 * 16 + 16);
    known += value > 0 ? 1 : 0;
  }
  EXPECT_GT(known, disparity.data.size() / 8);
}

TEST(DaemonMessages, SigtermEndsItCleanlyWithEveryPoseOfAProcessedFrameOut) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  Subscriber subscriber;
  const std::string dir = test::scratch_dir();
  test::Subprocess daemon({test::binary("cliquevod"), "--config", write_config(dir, small_course(10, 1.0, "pingpong")),
                           "--trajectory", dir + "/trajectory.txt"});
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while ((subscriber.statuses_seen < 12 || subscriber.healths_seen < 2) && std::chrono::steady_clock::now() < give_up) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  daemon.send(SIGTERM);
  const test::Finished end = daemon.wait();
  EXPECT_EQ(end.exit_code, 0) << end.err;
  subscriber.finish();
  const auto trajectory = daemon::read_trajectory(dir + "/trajectory.txt");
  ASSERT_TRUE(trajectory.ok());
  expect_one_of_each(subscriber, trajectory->poses.size());
  EXPECT_GE(trajectory->poses.size(), 12u) << "goes on beyond the course's end";
  ASSERT_GE(subscriber.healths.size(), 2u);
  const health_t& health = subscriber.healths.back();
  EXPECT_EQ(health.state, health_t::RUNNING) << health.state_text;
  EXPECT_GT(health.pose_rate_hz, 0.0);
  EXPECT_GT(health.latency_p50_us, 0);
  EXPECT_GT(health.resident_bytes, 1'000'000);
}

TEST(DaemonMessages, ACommandResetsThePose) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  Subscriber subscriber;
  const std::string config = write_config(test::scratch_dir(), small_course(10, 1.0, "pingpong") + kCommands);
  test::Subprocess daemon({test::binary("cliquevod"), "--config", config});
  lcm::LCM lcm(kUrl);
  command_t command{};
  command.command = command_t::RESET_POSE;
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  // Asked again and again: the daemon may not listen yet.
  while (subscriber.resets_seen == 0 && std::chrono::steady_clock::now() < give_up) {
    if (subscriber.statuses_seen > 5) lcm.publish("VO_COMMAND", &command);
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  daemon.send(SIGTERM);
  EXPECT_EQ(daemon.wait().exit_code, 0);
  subscriber.finish();
  ASSERT_GT(subscriber.resets_seen, 0);
  std::size_t reset = 1;
  while (subscriber.statuses[reset].resets == subscriber.statuses[reset - 1].resets) ++reset;
  EXPECT_EQ(subscriber.statuses[reset].status, status_t::NO_DATA);
  const double(&pos)[3] = subscriber.poses[reset].pos;
  EXPECT_EQ(Eigen::Vector3d(pos[0], pos[1], pos[2]).norm(), 0.0) << "the frame is the new origin";
  EXPECT_NE(subscriber.poses[reset - 1].pos[0], 0.0);
}

TEST(DaemonMessages, CommandsStartAndStopARecordingThatPlays) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  namespace fs = std::filesystem;
  Subscriber subscriber;
  const std::string dir = test::scratch_dir();
  const std::string config =
      write_config(dir, small_course(10, 1.0, "pingpong") + kCommands + "recording: {folder: " + dir + "/logs}\n");
  test::Subprocess daemon({test::binary("cliquevod"), "--config", config});
  lcm::LCM lcm(kUrl);
  const auto logs = [&] {
    std::vector<std::string> out;
    std::error_code none_yet;
    for (const auto& entry : fs::directory_iterator(dir + "/logs", none_yet)) out.push_back(entry.path().string());
    return out;
  };
  const auto ask = [&](std::int8_t what) {
    command_t command{};
    command.command = what;
    lcm.publish("VO_COMMAND", &command);
  };
  const auto until = [&](const auto& done, const auto& meanwhile) {
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (!done() && std::chrono::steady_clock::now() < give_up) {
      meanwhile();
      std::this_thread::sleep_for(std::chrono::milliseconds(100));
    }
    return done();
  };
  ASSERT_TRUE(until([&] { return logs().size() == 1; },
                    [&] {
                      if (subscriber.statuses_seen > 5) ask(command_t::START_RECORDING);
                    }));
  const int begun = subscriber.statuses_seen;
  ASSERT_TRUE(until([&] { return subscriber.statuses_seen > begun + 10; }, [] {}));
  ask(command_t::START_RECORDING);  // while one is written: nothing happens
  ASSERT_TRUE(until([&] { return subscriber.recording.load(); }, [] {}));
  ASSERT_TRUE(until([&] { return !subscriber.recording.load(); }, [&] { ask(command_t::STOP_RECORDING); }));
  ASSERT_EQ(logs().size(), 1U);
  const std::string first = logs()[0];
  const auto size = fs::file_size(first);
  const int stopped = subscriber.statuses_seen;
  ASSERT_TRUE(until([&] { return subscriber.statuses_seen > stopped + 5; }, [] {}));
  EXPECT_EQ(fs::file_size(first), size);
  // Another folder, read again while it runs, holds from the next recording on. One that began before it was read is
  // stopped again.
  write_config(dir, small_course(10, 1.0, "pingpong") + kCommands + "recording: {folder: " + dir + "/others}\n");
  daemon.send(SIGHUP);
  ASSERT_TRUE(until([&] { return fs::exists(dir + "/others") && !fs::is_empty(dir + "/others"); },
                    [&] { ask(subscriber.recording ? command_t::STOP_RECORDING : command_t::START_RECORDING); }));
  EXPECT_EQ(fs::file_size(first), size);
  daemon.send(SIGTERM);
  EXPECT_EQ(daemon.wait().exit_code, 0);
  const test::Finished replay = test::run({test::binary("cliquevo"), "replay", first});
  EXPECT_EQ(replay.exit_code, 0) << replay.err;
}

TEST(DaemonMessages, LcmsOwnPlayerPlaysALogOfOurs) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  if (test::run({"which", "lcm-logplayer"}).exit_code != 0) GTEST_SKIP() << "needs lcm-logplayer (liblcm-bin)";
  const std::string log = test::scratch_dir() + "/a.lcm";
  ASSERT_EQ(test::run({test::binary("cliquevo"), "record",
                       "sim:width=256,height=192,focal_px=280,frames=8,cache_dir=none", "--out", log})
                .exit_code,
            0);
  lcm::LCM receiver(kUrl);
  StereoCount count;
  receiver.subscribe("VO_STEREO", &StereoCount::on_images, &count)->setQueueCapacity(100);
  test::Subprocess player({"lcm-logplayer", "--lcm-url", kUrl, "--speed", "0.5", log});
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (count.images < 8 && std::chrono::steady_clock::now() < give_up) receiver.handleTimeout(100);
  EXPECT_EQ(player.wait().exit_code, 0);
  EXPECT_EQ(count.images, 8);
  EXPECT_EQ(count.width, 256);
}

TEST(DaemonMessages, WithoutARouteItSaysSoInOneLineAndEnds) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  const std::string config = write_config(test::scratch_dir(), small_course(2, 0.0, "none"));
  const test::Finished end = test::run({"unshare", "--net", test::binary("cliquevod"), "--config", config});
  EXPECT_EQ(end.exit_code, 1);
  EXPECT_EQ(test::lines_of(end.err).size(), 1u) << end.err;
  EXPECT_NE(end.err.find("ip route add 224.0.0.0/4 dev lo"), std::string::npos) << end.err;
}

}  // namespace
}  // namespace cliquevo
