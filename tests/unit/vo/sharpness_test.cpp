// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/sharpness.h"

#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace cliquevo::vo {
namespace {

constexpr int kWidth = 320;
constexpr int kHeight = 240;

// Random texture on random large parts.
Image<std::uint8_t> texture() {
  std::mt19937 rng(3);
  std::uniform_int_distribution<int> fine(-35, 35), large(70, 180);
  Image<std::uint8_t> out(kWidth, kHeight);
  std::vector<int> parts(400);
  for (int& p : parts) p = large(rng);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      out.view()(x, y) = static_cast<std::uint8_t>(parts[static_cast<std::size_t>(y / 32 * 20 + x / 32)] + fine(rng));
    }
  }
  return out;
}

Image<std::uint8_t> blurred(const Image<std::uint8_t>& from, int dx, int dy, int length) {
  Image<std::uint8_t> out(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      int sum = 0;
      for (int k = 0; k < length; ++k) {
        const int u = std::min(kWidth - 1, x + k * dx);
        const int v = std::min(kHeight - 1, y + k * dy);
        sum += from.cview()(u, v);
      }
      out.view()(x, y) = static_cast<std::uint8_t>(sum / length);
    }
  }
  return out;
}

Image<std::uint8_t> scaled(const Image<std::uint8_t>& from, double gain) {
  Image<std::uint8_t> out(kWidth, kHeight);
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) out.view()(x, y) = static_cast<std::uint8_t>(gain * from.cview()(x, y));
  }
  return out;
}

class ChangeByBlur : public testing::Test {
 protected:
  ChangeByBlur() : reference_(params_), current_(params_) {
    for (int y = 16; y < kHeight - 16; y += 14) {
      for (int x = 16; x < kWidth - 16; x += 14) {
        Feature f;
        f.x = x, f.y = y;
        const int i = static_cast<int>(reference_.features.size());
        matches_.push_back({i, i, 0});
        reference_.features.push_back(f);
        current_.features.push_back(f);
      }
    }
  }
  double change(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b) {
    reference_.left.copy_from(a.cview());
    current_.left.copy_from(b.cview());
    return change_by_blur(reference_, current_, matches_, scratch_);
  }

  VoParams params_;
  Frame reference_, current_;
  std::vector<Match> matches_;
  std::vector<float> scratch_;
};

TEST_F(ChangeByBlur, TheSamePictureHasNotChanged) {
  const Image<std::uint8_t> sharp = texture();
  EXPECT_EQ(change(sharp, sharp), 0.0);
}

TEST_F(ChangeByBlur, ExposureIsNoBlur) {
  const Image<std::uint8_t> sharp = texture();
  EXPECT_NEAR(change(sharp, scaled(sharp, 0.7)), 0.0, 1e-12);
}

TEST_F(ChangeByBlur, BlurExplainsThatPatchesNoLongerCorrelateEitherWay) {
  const Image<std::uint8_t> sharp = texture();
  const Image<std::uint8_t> soft = blurred(blurred(sharp, 1, 0, 2), 0, 1, 2);
  EXPECT_GT(change(sharp, soft), 0.3);
  EXPECT_GT(change(soft, sharp), 0.3);
}

TEST_F(ChangeByBlur, PicturesBlurredInTwoDirectionsLackAPartOfEachOther) {
  const Image<std::uint8_t> sharp = texture();
  const Image<std::uint8_t> across = blurred(sharp, 1, 0, 3);
  const Image<std::uint8_t> down = blurred(sharp, 0, 1, 3);
  EXPECT_GT(change(across, down), 0.1);
  EXPECT_EQ(change(across, across), 0.0);
}

TEST_F(ChangeByBlur, FewMatchesTellNothing) {
  const Image<std::uint8_t> sharp = texture();
  matches_.resize(10);
  EXPECT_EQ(change(sharp, blurred(sharp, 1, 0, 3)), 0.0);
}

}  // namespace
}  // namespace cliquevo::vo
