// SPDX-License-Identifier: BSD-3-Clause
// Patches of a picture that can be written down, looked for where it was moved, brightened, stretched or exchanged.
#include "core/vo/patch.h"

#include <algorithm>
#include <cmath>
#include <random>

#include <gtest/gtest.h>

namespace cliquevo::vo {
namespace {

struct Wave {
  double fx, fy, phase;
};

// Pixel (x, y) shows the texture at A (x - 32, y - 32) + (32, 32) + shift.
struct Look {
  double shift_x = 0.0, shift_y = 0.0;
  double stretch = 1.0;  // below 1: seen larger
  double gain = 1.0, bias = 0.0;
  double fy = 1.0;  // 0: the texture does not change downwards
};

Image<std::uint8_t> picture(unsigned seed, const Look& look = {}) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> frequency(-0.7, 0.7), phase(0.0, 6.28);
  Wave waves[10];
  for (Wave& w : waves) w = {frequency(rng), look.fy * frequency(rng), phase(rng)};
  Image<std::uint8_t> out(64, 64);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      const double u = look.stretch * (x - 32) + 32 + look.shift_x;
      const double v = look.stretch * (y - 32) + 32 + look.shift_y;
      double sum = 0.0;
      for (const Wave& w : waves) sum += std::sin(w.fx * u + w.fy * v + w.phase);
      out.view()(x, y) =
          static_cast<std::uint8_t>(std::lround(std::clamp(look.gain * (110.0 + 18.0 * sum) + look.bias, 0.0, 255.0)));
    }
  }
  return out;
}

Template cut(const Image<std::uint8_t>& image, int radius) {
  Template t;
  EXPECT_TRUE(cut_template(image.cview(), 32.0F, 32.0F, radius, t));
  return t;
}

TEST(PatchFit, FindsAMovedPatchToAFewHundredthsOfAPixel) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const Template t = cut(picture(seed), 4);
    const Image<std::uint8_t> moved = picture(seed, {.shift_x = 0.83, .shift_y = -1.37});
    const PatchFit fit = fit_patch(t, moved.cview(), 32.0F, 32.0F, {}, SearchAxes::both, {});
    ASSERT_TRUE(fit.ok) << seed;
    EXPECT_NEAR(fit.x, 32.0F - 0.83F, 0.06F) << seed;
    EXPECT_NEAR(fit.y, 32.0F + 1.37F, 0.06F) << seed;
    EXPECT_GT(fit.correlation, 0.99F);
  }
}

TEST(PatchFit, ExposureMovesNothingAndIsMeasured) {
  const Template t = cut(picture(1), 4);
  const Image<std::uint8_t> darker = picture(1, {.shift_x = 0.5, .gain = 0.7, .bias = 10.0});
  const PatchFit fit = fit_patch(t, darker.cview(), 32.0F, 32.0F, {}, SearchAxes::both, {});
  ASSERT_TRUE(fit.ok);
  EXPECT_NEAR(fit.x, 31.5F, 0.06F);
  EXPECT_NEAR(fit.y, 32.0F, 0.06F);
  const Image<std::uint8_t> brighter = picture(1, {.bias = 20.0});
  const float contrast = std::sqrt(t.inner.tt / 81.0F);
  EXPECT_NEAR(fit_patch(t, brighter.cview(), 32.0F, 32.0F, {}, SearchAxes::both, {}).brighter, 20.0F / contrast,
              0.5F / contrast);
}

TEST(PatchFit, AStretchedPatchIsFoundBetterWithItsWarp) {
  const Template t = cut(picture(2), 7);
  const Image<std::uint8_t> larger = picture(2, {.stretch = 1.0 / 1.25});
  const PatchParams params{.radius = 7};
  Warp warp;
  warp.xx = warp.yy = 1.25F;
  const PatchFit warped = fit_patch(t, larger.cview(), 32.4F, 31.7F, warp, SearchAxes::both, params);
  const PatchFit plain = fit_patch(t, larger.cview(), 32.4F, 31.7F, {}, SearchAxes::both, params);
  ASSERT_TRUE(warped.ok);
  EXPECT_NEAR(warped.x, 32.0F, 0.06F);
  EXPECT_NEAR(warped.y, 32.0F, 0.06F);
  EXPECT_GT(warped.correlation, 0.99F);
  EXPECT_LT(plain.correlation, warped.correlation - 0.03F);
}

TEST(PatchFit, StripesFixAPlaceAlongTheRowAlone) {
  const Template t = cut(picture(3, {.fy = 0.0}), 4);
  const Image<std::uint8_t> moved = picture(3, {.shift_x = 0.6, .fy = 0.0});
  EXPECT_FALSE(fit_patch(t, moved.cview(), 32.0F, 32.0F, {}, SearchAxes::both, {}).ok);
  const PatchFit along = fit_patch(t, moved.cview(), 32.0F, 32.3F, {}, SearchAxes::row_only, {});
  ASSERT_TRUE(along.ok);
  EXPECT_NEAR(along.x, 31.4F, 0.06F);
  EXPECT_EQ(along.y, 32.3F) << "the row is given";
}

TEST(PatchFit, FailsWhereThereIsNothingToFind) {
  const Image<std::uint8_t> image = picture(4);
  const Template t = cut(image, 4);
  Image<std::uint8_t> flat(64, 64);
  flat.fill(90);
  EXPECT_FALSE(fit_patch(t, flat.cview(), 32.0F, 32.0F, {}, SearchAxes::both, {}).ok) << "no texture";
  EXPECT_FALSE(fit_patch(cut(flat, 4), image.cview(), 32.0F, 32.0F, {}, SearchAxes::both, {}).ok) << "no template";
  EXPECT_FALSE(fit_patch(t, image.cview(), 4.0F, 32.0F, {}, SearchAxes::both, {}).ok) << "beyond the border";
  EXPECT_FALSE(fit_patch(t, image.cview(), std::nanf(""), 32.0F, {}, SearchAxes::both, {}).ok);
  EXPECT_FALSE(
      fit_patch(t, picture(4, {.shift_x = 0.9}).cview(), 32.0F, 32.0F, {}, SearchAxes::both, {.max_shift_px = 0.5}).ok)
      << "farther than allowed";
}

TEST(PatchFit, AnotherTextureIsNotTheSame) {
  const Template t = cut(picture(5), 4);
  int same = 0;
  for (unsigned seed = 100; seed < 130; ++seed) {
    const PatchFit fit = fit_patch(t, picture(seed).cview(), 32.0F, 32.0F, {}, SearchAxes::both, {});
    same += fit.ok ? 1 : 0;
  }
  EXPECT_LE(same, 3) << "of 30 smooth pictures some look alike";
}

TEST(PatchFit, WhatMayDifferIsAMatterOfNoiseOrOfContrast) {
  const Template t = cut(picture(6), 4);
  Image<std::uint8_t> noisy = picture(6);
  std::mt19937 rng(1);
  std::normal_distribution<double> noise(0.0, 25.0);
  for (int y = 0; y < 64; ++y) {
    for (int x = 0; x < 64; ++x) {
      noisy.view()(x, y) = static_cast<std::uint8_t>(std::clamp(noisy.view()(x, y) + noise(rng), 0.0, 255.0));
    }
  }
  const auto fits = [&](double max_residual, double min_correlation) {
    return fit_patch(t, noisy.cview(), 32.0F, 32.0F, {}, SearchAxes::both,
                     {.max_residual = max_residual, .min_correlation = min_correlation})
        .ok;
  };
  EXPECT_FALSE(fits(8.0, 0.999));
  EXPECT_TRUE(fits(60.0, 0.999)) << "the camera is known to be so noisy";
  EXPECT_TRUE(fits(8.0, 0.5)) << "most of the contrast is shared";
}

TEST(Template, IsCutInsideTheImageOnly) {
  const Image<std::uint8_t> image = picture(7);
  Template t;
  EXPECT_TRUE(cut_template(image.cview(), 5.0F, 5.0F, 4, t));
  EXPECT_FALSE(cut_template(image.cview(), 4.9F, 20.0F, 4, t));
  EXPECT_FALSE(cut_template(image.cview(), 20.0F, 57.0F, 4, t));
  EXPECT_FALSE(cut_template(image.cview(), std::nanf(""), 20.0F, 4, t));
}

}  // namespace
}  // namespace cliquevo::vo
