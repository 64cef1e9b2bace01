// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/matches.h"

#include <random>

#include <gtest/gtest.h>

namespace cliquevo::vo {
namespace {

Image<std::uint8_t> random_image(unsigned seed) {
  std::mt19937 rng(seed);
  Image<std::uint8_t> image(200, 150);
  for (int y = 0; y < 150; ++y) {
    for (int x = 0; x < 200; ++x) image.view()(x, y) = static_cast<std::uint8_t>(rng() % 63);
  }
  return image;
}

std::vector<Feature> grid_features(int count) {
  std::vector<Feature> features;
  for (int i = 0; i < count; ++i) {
    Feature f;
    f.x = 12 + i % 14 * 12;
    f.y = 12 + i / 14 * 12;
    features.push_back(f);
  }
  return features;
}

TEST(Matches, TheSameFeaturesInAnotherOrderFindThemselvesAgain) {
  const Image<std::uint8_t> image = random_image(1);
  const std::vector<Feature> a = grid_features(100);
  const std::vector<Feature> b(a.rbegin(), a.rend());
  Descriptors da(128), db(128);
  da.extract(image.cview(), a, 7);
  db.extract(image.cview(), b, 7);
  std::vector<Match> matches;
  Matcher(128).match(da, db, matches);
  ASSERT_EQ(matches.size(), a.size());
  for (const Match& m : matches) {
    EXPECT_EQ(m.b, 99 - m.a);
    EXPECT_EQ(m.score, 0);
  }
}

TEST(Matches, ADescriptorLeavesOutItsCentre) {
  Image<std::uint8_t> image = random_image(2);
  const std::vector<Feature> features = grid_features(1);
  Descriptors before(1), after(1);
  before.extract(image.cview(), features, 7);
  EXPECT_EQ(before.length(), 48);
  image.view()(12, 12) = static_cast<std::uint8_t>(image.view()(12, 12) + 1);
  after.extract(image.cview(), features, 7);
  EXPECT_EQ(0, memcmp(before[0], after[0], 48));
  image.view()(9, 9) = static_cast<std::uint8_t>(image.view()(9, 9) + 1);  // a corner of the window belongs to it
  after.extract(image.cview(), features, 7);
  EXPECT_NE(0, memcmp(before[0], after[0], 48));
}

TEST(Matches, OnlyCooccurringMinimaMatch) {
  // b[0] is the best for both a's, which can only be matched once; frames without features match nothing.
  Image<std::uint8_t> image(100, 50);
  image.fill(0);
  image.view()(30, 20) = 40;
  image.view()(60, 20) = 41;
  std::vector<Feature> a(2), b(1);
  a[0].x = 31, a[0].y = 20;
  a[1].x = 61, a[1].y = 20;
  b[0].x = 61, b[0].y = 20;
  Descriptors da(2), db(2);
  da.extract(image.cview(), a, 7);
  db.extract(image.cview(), b, 7);
  std::vector<Match> matches;
  Matcher matcher(2);
  matcher.match(da, db, matches);
  ASSERT_EQ(matches.size(), 1u);
  EXPECT_EQ(matches[0].a, 1);
  db.extract(image.cview(), {}, 7);
  matcher.match(da, db, matches);
  EXPECT_TRUE(matches.empty());
}

}  // namespace
}  // namespace cliquevo::vo
