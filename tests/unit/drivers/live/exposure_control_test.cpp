// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/live/exposure_control.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace cliquevo::drivers {
namespace {

// A camera before a wall of many brightnesses: what it sees is radiance x exposure x 2^gain, cut off at white.
struct MadeUpCamera {
  double radiance = 1.0;  // mean grey levels a microsecond
  double doublings_a_gain = 1.0;
  ExposureRange range{{20.0, 0.0}, {30'000.0, 4.0}};
  ExposureSetting setting{1000.0, 0.0};
  Image<std::uint8_t> picture;

  ImageView<const std::uint8_t> shoot() {
    picture.resize(320, 240);
    const double factor = radiance * setting.exposure_us * std::exp2(setting.gain * doublings_a_gain);
    for (int y = 0; y < 240; ++y) {
      for (int x = 0; x < 320; ++x) {
        const double wall = std::exp(0.8 * std::sin(0.21 * x + 0.03 * y) + 0.8 * std::sin(0.17 * y - 0.05 * x));
        const double noise = ((x * 7 + y * 13) % 5 - 2) * 0.8;
        picture.view().row(y)[x] = static_cast<std::uint8_t>(std::clamp(std::round(factor * wall + noise), 0.0, 255.0));
      }
    }
    return picture.cview();
  }
  // So many times a quarter of a second.
  void control(int times) {
    for (int i = 0; i < times; ++i) setting = next_exposure(shoot(), setting, range);
  }
};

TEST(ExposureControl, APictureThatIsTooDarkOrTooBrightIsToldFromOneThatIsRight) {
  MadeUpCamera camera;
  camera.radiance = 0.06;
  EXPECT_NEAR(best_gamma(camera.shoot()), 1.0, 0.35);
  camera.radiance = 0.01;
  EXPECT_LT(best_gamma(camera.shoot()), 0.8);
  camera.radiance = 0.4;
  EXPECT_GT(best_gamma(camera.shoot()), 1.2);
}

TEST(ExposureControl, FindsTheExposureFromFarOffAndStaysThere) {
  for (const double start_us : {20.0, 200.0, 5000.0, 30'000.0}) {
    MadeUpCamera camera;
    camera.radiance = 0.05;
    camera.setting.exposure_us = start_us;
    camera.control(40);
    const ExposureSetting found = camera.setting;
    EXPECT_NEAR(best_gamma(camera.shoot()), 1.0, 0.1) << start_us;
    camera.control(10);
    EXPECT_EQ(camera.setting, found) << start_us;
  }
}

TEST(ExposureControl, TheLimitHoldsAndTheGainMakesUpForIt) {
  for (const double doublings : {0.5, 1.0, 2.0}) {
    MadeUpCamera camera;
    camera.radiance = 0.01;
    camera.doublings_a_gain = doublings;
    camera.range.most.exposure_us = 2000.0;
    for (int i = 0; i < 60; ++i) {
      camera.control(1);
      ASSERT_LE(camera.setting.exposure_us, 2000.0);
      ASSERT_LE(camera.setting.gain, camera.range.most.gain);
    }
    EXPECT_EQ(camera.setting.exposure_us, 2000.0);
    EXPECT_GT(camera.setting.gain, 0.0);
    EXPECT_NEAR(best_gamma(camera.shoot()), 1.0, 0.1) << doublings;
  }
}

TEST(ExposureControl, TheGainGoesDownBeforeTheExposureTime) {
  MadeUpCamera camera;
  camera.radiance = 0.2;
  camera.setting = {2000.0, 3.0};
  camera.range.most.exposure_us = 2000.0;
  camera.control(1);
  EXPECT_EQ(camera.setting.exposure_us, 2000.0);
  EXPECT_LT(camera.setting.gain, 3.0);
  camera.control(40);
  EXPECT_EQ(camera.setting.gain, 0.0);
  EXPECT_LT(camera.setting.exposure_us, 2000.0);
}

TEST(ExposureControl, FindsItsWayOutOfBlackAndWhite) {
  for (const double radiance : {1e-5, 50.0}) {
    MadeUpCamera camera;
    camera.radiance = radiance;
    camera.control(60);
    const bool at_an_end = camera.setting.exposure_us >= camera.range.most.exposure_us ||
                           camera.setting.exposure_us <= camera.range.least.exposure_us;
    EXPECT_TRUE(at_an_end) << camera.setting.exposure_us;
    camera.radiance = 0.05;
    camera.control(60);
    EXPECT_NEAR(best_gamma(camera.shoot()), 1.0, 0.1);
  }
}

TEST(ExposureControl, WithoutAGainTheExposureAloneActs) {
  MadeUpCamera camera;
  camera.radiance = 0.001;
  camera.range.most = {3000.0, 0.0};
  camera.control(30);
  EXPECT_EQ(camera.setting, (ExposureSetting{3000.0, 0.0}));
}

}  // namespace
}  // namespace cliquevo::drivers
