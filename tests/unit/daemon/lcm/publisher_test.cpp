// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/lcm/publisher.h"

#include <bot_core/pose_t.hpp>
#include <fovis/update_t.hpp>

#include <cliquevo/odometry_t.hpp>
#include <cliquevo/status_t.hpp>
#include <lcm/lcm-cpp.hpp>

#include "tests/support/test_data.h"
#include "tests/unit/daemon/lcm/made_up_frames.h"

namespace cliquevo::daemon {
namespace {

// LCM's event log as transport: the very bytes, without a network.
LcmConfig to_log(const std::string& path) {
  LcmConfig config;
  config.url = "file://" + path + "?mode=w";
  return config;
}

template <typename Message>
Message decoded(const lcm::LogEvent& event) {
  Message message{};
  EXPECT_EQ(message.decode(event.data, 0, event.datalen), event.datalen);
  return message;
}

TEST(Publisher, EveryFrameGivesOneMessageOnEachChannelInOrder) {
  const std::string path = test::scratch_dir() + "/out.log";
  constexpr int kFrames = 20;
  {
    LcmConfig config = to_log(path);
    config.pose_channel = "POSE_BODY_ALT";
    auto publisher = Publisher::make(config, forward_camera());
    ASSERT_TRUE(publisher.ok()) << publisher.error().line();
    PublishedFrame frame = frame_at(0, vo::Status::no_data, {});
    RigidTransform forward;
    forward.t = {0.0, 0.0, 0.1};
    for (int i = 0; i < kFrames; ++i) {
      ASSERT_TRUE(publisher->publish(frame));
      frame = next_valid(frame, forward);
    }
  }
  lcm::LogFile log(path, "r");
  ASSERT_TRUE(log.good());
  for (int i = 0; i < kFrames; ++i) {
    const TimestampNs stamp_ns = kFirstStampNs + i * kPeriodNs;
    const std::int64_t utime = stamp_ns / 1000;
    const lcm::LogEvent* event = log.readNextEvent();
    ASSERT_NE(event, nullptr);
    EXPECT_EQ(event->channel, "VO_DELTA_CAMERA");
    const auto delta = decoded<fovis::update_t>(*event);
    EXPECT_EQ(delta.timestamp, utime);
    EXPECT_EQ(delta.prev_timestamp, i == 0 ? utime : (stamp_ns - kPeriodNs) / 1000);
    event = log.readNextEvent();
    ASSERT_NE(event, nullptr);
    EXPECT_EQ(event->channel, "POSE_BODY_ALT");
    const auto pose = decoded<bot_core::pose_t>(*event);
    EXPECT_EQ(pose.utime, utime);
    EXPECT_NEAR(pose.pos[0], 0.1 * i, 1e-9);
    event = log.readNextEvent();
    ASSERT_NE(event, nullptr);
    EXPECT_EQ(event->channel, "VO_STATUS");
    const auto status = decoded<status_t>(*event);
    EXPECT_EQ(status.utime, utime);
    EXPECT_EQ(status.frame, i);
    EXPECT_GT(status.publish_utime, 1'600'000'000'000'000);
    event = log.readNextEvent();
    ASSERT_NE(event, nullptr);
    EXPECT_EQ(event->channel, "VO_ODOMETRY");
    const auto odometry = decoded<odometry_t>(*event);
    EXPECT_EQ(odometry.utime, utime);
    EXPECT_NEAR(odometry.position[0], 0.1 * i, 1e-9);
  }
  EXPECT_EQ(log.readNextEvent(), nullptr);
}

TEST(Publisher, AnUnusableUrlOrChannelIsAnErrorNotACrash) {
  LcmConfig config;
  config.url = "udpm://no.such.address:7667";
  auto publisher = Publisher::make(config, {});
  ASSERT_FALSE(publisher.ok());
  EXPECT_NE(publisher.error().line().find(config.url), std::string::npos);
  config = to_log(test::scratch_dir() + "/out.log");
  config.status_channel = std::string(64, 'X');
  publisher = Publisher::make(config, {});
  ASSERT_FALSE(publisher.ok());
  EXPECT_NE(publisher.error().line().find("lcm.status_channel"), std::string::npos);
  config = to_log("/no/such/folder/out.log");
  EXPECT_FALSE(Publisher::make(config, {}).ok());
}

}  // namespace
}  // namespace cliquevo::daemon
