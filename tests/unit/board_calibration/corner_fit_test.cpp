// SPDX-License-Identifier: BSD-3-Clause
// Drawn crossings of two edges: found where they are, and nothing is found in another pattern.
#include "tools/calibrate/corner_fit.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace cliquevo::tools {
namespace {

constexpr int kSize = 40;
const Eigen::Vector2d kAt(19.3, 20.8);

// Each pixel the mean of 16 x 16 places of dark or bright; with noise.
template <typename Bright>
Image<std::uint8_t> drawn(Bright&& bright, double noise) {
  std::mt19937 bits(3);
  std::normal_distribution<double> normal;
  Image<std::uint8_t> out(kSize, kSize);
  for (int y = 0; y < kSize; ++y) {
    for (int x = 0; x < kSize; ++x) {
      double sum = 0.0;
      for (int k = 0; k < 256; ++k) {
        const Eigen::Vector2d at(x - 0.5 + (k % 16 + 0.5) / 16.0, y - 0.5 + (k / 16 + 0.5) / 16.0);
        sum += bright(at - kAt) ? 200.0 : 40.0;
      }
      out.view()(x, y) = static_cast<std::uint8_t>(std::clamp(sum / 256.0 + noise * normal(bits) + 0.5, 0.0, 255.0));
    }
  }
  return out;
}

CornerWindow window_along(const Eigen::Vector2d& x, const Eigen::Vector2d& y) {
  CornerWindow out;
  out.px_of_board << x, y;
  out.reach = 0.75;
  out.free = 1.0;
  return out;
}

TEST(CornerFit, FindsACrossingToAHundredthOfAPixel) {
  const Eigen::Vector2d along_x(14.0, 3.0), along_y(-5.0, 12.0);
  const auto side = [](const Eigen::Vector2d& along, const Eigen::Vector2d& p) {
    return along.x() * p.y() - along.y() * p.x() > 0.0;
  };
  const auto image = drawn([&](const auto& p) { return side(along_x, p) == side(along_y, p); }, 2.0);
  const auto found = fit_corner(image.cview(), kAt + Eigen::Vector2d(0.3, -0.25), window_along(along_x, along_y));
  ASSERT_TRUE(found);
  EXPECT_LT((*found - kAt).norm(), 0.02) << found->transpose();
}

// Lines that a lens bends: the crossing is where they meet, not where their chords do.
TEST(CornerFit, FollowsEdgesThatAreBent) {
  constexpr double kBend = 0.008;  // 1/px
  const auto image = drawn([&](const auto& p) { return (p.y() > 0.5 * kBend * p.x() * p.x()) == (p.x() > 0.0); }, 0.0);
  CornerWindow window = window_along({16.0, 0.0}, {0.0, 16.0});
  const auto straight = fit_corner(image.cview(), kAt, window);
  window.curvature[0] = kBend;
  const auto bent = fit_corner(image.cview(), kAt, window);
  ASSERT_TRUE(straight && bent);
  EXPECT_GT((*straight - kAt).norm(), 0.08);
  EXPECT_LT((*bent - kAt).norm(), 0.015) << bent->transpose();
}

TEST(CornerFit, FindsNothingInAnotherPattern) {
  const CornerWindow window = window_along({16.0, 0.0}, {0.0, 16.0});
  const auto of = [&](auto&& bright) { return fit_corner(drawn(bright, 1.0).cview(), kAt, window); };
  EXPECT_FALSE(of([](const auto&) { return true; })) << "flat";
  EXPECT_FALSE(of([](const auto& p) { return p.x() > 0.0; })) << "one edge";
  EXPECT_FALSE(of([](const auto& p) { return p.x() > 0.0 && p.y() > 0.0; })) << "a corner of one square";
  EXPECT_FALSE(of([](const auto& p) { return (p.x() > 3.0) == (p.y() > 0.0); })) << "three pixels beside it";
  Image<std::uint8_t> small(3, 3);
  for (int y = 0; y < 3; ++y) std::fill_n(small.view().row(y), 3, std::uint8_t{100});
  EXPECT_FALSE(fit_corner(small.cview(), {1.0, 1.0}, window)) << "too few pixels";
}

}  // namespace
}  // namespace cliquevo::tools
