// SPDX-License-Identifier: BSD-3-Clause
// A daemon's messages as `cliquevo echo` and `cliquevo watch` show them.
#include <string>
#include <vector>

#include <cliquevo/update_t.hpp>
#include <gtest/gtest.h>

#include "tools/message_json.h"
#include "tools/watch_lines.h"

namespace cliquevo::tools {
namespace {

constexpr TimestampNs kSecond = 1'000'000'000;

template <typename Message>
std::vector<char> encoded(const Message& message) {
  std::vector<char> out(static_cast<std::size_t>(message.getEncodedSize()));
  message.encode(out.data(), 0, static_cast<int>(out.size()));
  return out;
}

TEST(MessageJson, EveryMemberComesUnderItsName) {
  pose_t pose{};
  pose.utime = 1234567;
  pose.pos[1] = -2.5;
  const auto bytes = encoded(pose);
  const auto read = message_json(bytes.data(), bytes.size());
  ASSERT_TRUE(read);
  EXPECT_EQ((*read)["utime"], 1234567);
  EXPECT_EQ((*read)["pos"][1], -2.5);
  health_t health{};
  health.state_text = "running";
  health.num_stages = 1;
  health.stage_name = {"stereo"};
  health.stage_p50_us = {5};
  health.stage_p99_us = {7};
  const auto more = encoded(health);
  EXPECT_EQ((*message_json(more.data(), more.size()))["stage_name"][0], "stereo");
}

TEST(MessageJson, DamagedMessagesAndThoseOfOthersAreNone) {
  const auto bytes = encoded(status_t{});
  EXPECT_TRUE(message_json(bytes.data(), bytes.size()));
  for (std::size_t size = 0; size < bytes.size(); ++size) EXPECT_FALSE(message_json(bytes.data(), size)) << size;
  const std::vector<char> other(200, 'x');
  EXPECT_FALSE(message_json(other.data(), other.size()));
}

status_t status(int verdict, std::int32_t failed) {
  status_t out{};
  out.status = static_cast<std::int8_t>(verdict);
  out.checks_failed = failed;
  out.grabbed_utime = 1000;
  out.publish_utime = 8500;
  return out;
}

TEST(WatchedDaemon, CountsTheLastVerdictsAndNamesWhatFailed) {
  WatchedDaemon watched;
  EXPECT_NE(watched.lines(kSecond).find("no messages yet"), std::string::npos);
  watched.take(status(status_t::VALID, 0), kSecond);
  for (int i = 0; i < 3; ++i) watched.take(status(status_t::VALID, 0), 20 * kSecond);
  watched.take(status(status_t::AMBIGUOUS, 1 << status_t::CHECK_RIVAL), 20 * kSecond);
  const std::string lines = watched.lines(20 * kSecond);
  EXPECT_NE(lines.find("3 valid, 1 ambiguous; last failed: rival motion"), std::string::npos) << lines;
  EXPECT_NE(lines.find("median 7.5 ms"), std::string::npos) << lines;
  EXPECT_NE(watched.line(25 * kSecond).find("silent for 5 s"), std::string::npos);
}

TEST(WatchedDaemon, ShowsTheSelfCheckAndNothingThatATerminalObeys) {
  WatchedDaemon watched;
  health_t health{};
  health.state_text = "running";
  health.pose_rate_hz = 29.97;
  health.calibration_text = "the calibration agrees\x1b[2J";
  watched.take(health, kSecond);
  const std::string lines = watched.lines(kSecond);
  EXPECT_NE(lines.find("30.0 Hz out"), std::string::npos) << lines;
  EXPECT_NE(lines.find("the calibration agrees"), std::string::npos);
  EXPECT_EQ(lines.find('\x1b'), std::string::npos);
}

}  // namespace
}  // namespace cliquevo::tools
