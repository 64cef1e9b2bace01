// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view/store.h"

#include <cstring>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace cliquevo::view {
namespace {

FrameFacts frame(std::int64_t i) {
  FrameFacts out;
  out.index = i;
  out.stamp_us = 1000 * i;
  return out;
}

std::uint32_t number(const std::string& message, std::size_t at) {
  std::uint32_t out = 0;
  std::memcpy(&out, message.data() + at, sizeof out);
  return out;
}

TEST(Store, WhatGoesInComesOut) {
  auto made = Store::make(1 << 20, 100);
  ASSERT_TRUE(made.ok());
  Store& store = **made;
  for (int i = 0; i < 5; ++i) {
    FrameParts parts;
    parts.features = Bytes(28, static_cast<unsigned char>(i));
    parts.left = Bytes(100, static_cast<unsigned char>(10 + i));
    store.add(frame(i), parts);
  }
  std::int64_t from = 2;
  std::string text(1, '[');
  text.append(store.records(from, 2)).push_back(']');
  const auto records = nlohmann::json::parse(text);
  EXPECT_EQ(records.size(), 2U);
  EXPECT_EQ(records[0]["i"], 2);
  EXPECT_EQ(from, 4);
  const std::string message = store.frame_message(3, kFeatures | kLeft);
  ASSERT_EQ(message.size(), 64U + 28 + 100);
  EXPECT_EQ(message.substr(0, 4), "CVF1");
  EXPECT_EQ(number(message, 4), 3U);
  EXPECT_EQ(message[64], 3);
  EXPECT_EQ(message[64 + 28], 13);
  EXPECT_EQ(store.frame_message(3, kLeft).size(), 164U);
  for (const std::int64_t n : {std::int64_t{-1}, std::int64_t{5}, INT64_MIN, INT64_MAX}) {
    EXPECT_EQ(store.frame_message(n, 15).size(), 64U) << n;
  }
}

TEST(Store, NeitherRecordsNorPicturesGrowBeyondTheirMost) {
  auto made = Store::make(64 * 1024, 50);
  ASSERT_TRUE(made.ok());
  Store& store = **made;
  for (int i = 0; i < 500; ++i) {
    FrameParts parts;
    parts.left = Bytes(3000, static_cast<unsigned char>(i));
    store.add(frame(i), parts);
  }
  EXPECT_EQ(store.extent().first, 450);
  EXPECT_EQ(store.extent().end, 500);
  const std::string newest = store.frame_message(499, kLeft);
  EXPECT_EQ(newest.size(), 64U + 3000);
  EXPECT_EQ(static_cast<unsigned char>(newest.back()), 499 % 256);
  EXPECT_EQ(store.frame_message(455, kLeft).size(), 64U);  // written over
  std::int64_t from = 0;
  store.records(from, 10);
  EXPECT_EQ(from, 460);
}

TEST(Store, AFrameWithoutAPictureShowsTheOneBefore) {
  auto made = Store::make(1 << 20, 100);
  ASSERT_TRUE(made.ok());
  Store& store = **made;
  for (int i = 0; i < 4; ++i) store.add(frame(i), {});
  FrameParts late;
  late.left = Bytes(10, 'x');
  EXPECT_TRUE(store.add_pictures(1000, late));
  EXPECT_FALSE(store.add_pictures(77, late));
  const std::string message = store.frame_message(3, kLeft);
  EXPECT_EQ(message.size(), 74U);
  EXPECT_EQ(number(message, 28), 1U);
  EXPECT_EQ(store.frame_message(0, kLeft).size(), 64U);
}

TEST(Store, APictureThatThePageHasIsNotSentAgain) {
  auto made = Store::make(1 << 20, 100);
  ASSERT_TRUE(made.ok());
  Store& store = **made;
  FrameParts parts;
  parts.features = Bytes(28, 'f');
  parts.left = Bytes(100, 'l');
  store.add(frame(0), parts);
  parts.left.clear();
  store.add(frame(1), parts);
  const std::string message = store.frame_message(1, kFeatures | kLeft, 0);
  EXPECT_EQ(message.size(), 64U + 28) << "the features are another frame's";
  EXPECT_EQ(number(message, 28), 0U);
  EXPECT_EQ(store.frame_message(1, kFeatures | kLeft, 1).size(), 64U + 28 + 100);
}

}  // namespace
}  // namespace cliquevo::view
