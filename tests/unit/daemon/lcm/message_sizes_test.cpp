// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/lcm/message_sizes.h"

#include <vector>

#include <cliquevo/pose_t.hpp>
#include <gtest/gtest.h>

namespace cliquevo::daemon {
namespace {

template <typename Message>
std::vector<std::uint8_t> encoded(const Message& message) {
  std::vector<std::uint8_t> out(static_cast<std::size_t>(message.getEncodedSize()));
  EXPECT_EQ(message.encode(out.data(), 0, static_cast<int>(out.size())), static_cast<int>(out.size()));
  return out;
}

// It fits as it is, with no byte fewer or more, and with no four bytes in it made a huge number where they were a
// count.
template <typename Message>
void expect_exact(const Message& message, int counts) {
  std::vector<std::uint8_t> bytes = encoded(message);
  ASSERT_TRUE(fits({bytes.data(), bytes.size()}, message));
  for (std::size_t size = 0; size < bytes.size(); ++size) EXPECT_FALSE(fits({bytes.data(), size}, message)) << size;
  bytes.push_back(0);
  EXPECT_FALSE(fits({bytes.data(), bytes.size()}, message));
  bytes.pop_back();
  int refused = 0;
  for (std::size_t at = 0; at + 4 <= bytes.size(); ++at) {
    std::vector<std::uint8_t> huge = bytes;
    huge[at] = 0x7F;
    for (std::size_t k = 1; k < 4; ++k) huge[at + k] = 0xF0;
    refused += fits({huge.data(), huge.size()}, message) ? 0 : 1;
  }
  EXPECT_GE(refused, counts) << "each count is looked at";
}

image_t image(std::size_t bytes, int entries) {
  image_t out{};
  out.data.assign(bytes, 1);
  out.size = static_cast<std::int32_t>(bytes);
  out.nmetadata = entries;
  for (int k = 0; k < entries; ++k) {
    image_metadata_t entry;
    entry.key = "fx_px";
    entry.value.assign(3, '1');
    entry.n = 3;
    out.metadata.push_back(entry);
  }
  return out;
}

TEST(MessageSizes, EveryTypeWithCountsIsWalkedToItsEnd) {
  features_t features{};
  features.num_checks = 2;
  features.check_value = features.check_bound = {1.0, 2.0};
  features.num_features = 3;
  features.x = features.y = features.from_x = features.from_y = features.disparity = features.error = {1, 2, 3};
  features.role = {0, 1, 2};
  expect_exact(features, 2);

  health_t health{};
  health.state_text = "running";
  health.num_stages = 2;
  health.stage_name = {"stereo", "odometry"};
  health.stage_p50_us = health.stage_p99_us = {1, 2};
  health.num_temperatures = 1;
  health.temperature_name = {"cpu"};
  health.temperature_c = {50.0};
  health.view_text = "free";
  expect_exact(health, 2);

  images_t images{};
  images.n_images = 2;
  images.image_types = {images_t::LEFT, images_t::RIGHT};
  images.images = {image(12, 2), image(0, 0)};
  expect_exact(images, 5);

  movers_t movers{};
  movers.num_movers = 2;
  movers.movers.resize(2);
  movers.movers[1].num_points = 2;
  movers.movers[1].pixel.assign(2, {1.0F, 2.0F});
  movers.movers[1].point.assign(2, {1.0F, 2.0F, 3.0F});
  expect_exact(movers, 3);

  points_t points{};
  points.num_points = 2;
  points.x = points.y = points.z = points.sigma = {1.0F, 2.0F};
  points.grey = {1, 2};
  expect_exact(points, 1);

  command_t command{};
  command.argument = "name";
  expect_exact(command, 1);

  status_t status{};
  status.n_checks = 3;
  status.check_ratio = {1.0, 2.0, 3.0};
  expect_exact(status, 1);
}

TEST(MessageSizes, AHugeCountIsNoMessageAndTakesNoMemory) {
  images_t images{};
  images.n_images = 1;
  images.image_types = {images_t::LEFT};
  images.images = {image(12, 0)};
  std::vector<std::uint8_t> bytes = encoded(images);
  images_t out;
  EXPECT_TRUE(decode_checked(bytes.data(), bytes.size(), out));
  const std::size_t count = 8 + 8;  // behind the fingerprint and the time
  bytes[count] = 0x7F;
  EXPECT_FALSE(decode_checked(bytes.data(), bytes.size(), out));
  bytes[count] = 0xFF;
  EXPECT_FALSE(decode_checked(bytes.data(), bytes.size(), out)) << "a negative one";
}

TEST(MessageSizes, WhatHasNoCountsAlwaysFits) { EXPECT_TRUE(fits({}, pose_t{})); }

}  // namespace
}  // namespace cliquevo::daemon
