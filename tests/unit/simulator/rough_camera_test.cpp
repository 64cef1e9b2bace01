// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/rough_camera.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "drivers/simulator.h"
#include "drivers/simulator/camera_sets.h"
#include "drivers/simulator/jpeg.h"
#include "drivers/simulator/render_cache.h"
#include "drivers/simulator/renderer.h"
#include "drivers/simulator/world.h"

namespace cliquevo::drivers {
namespace {

using sim::roughen;

SimulatorOptions options_of(const std::string& text) {
  const auto o = parse_simulator_options("width=128,height=96,focal_px=140,cache_dir=none," + text);
  EXPECT_TRUE(o.ok()) << o.error().line();
  return sim::with_camera(*o);
}

// Sixteenths of grey levels.
template <typename F>
Image<std::uint16_t> drawn(F&& f) {
  Image<std::uint16_t> image(128, 96);
  for (int y = 0; y < 96; ++y)
    for (int x = 0; x < 128; ++x) image.view()(x, y) = static_cast<std::uint16_t>(std::lround(f(x, y)));
  return image;
}

double waves(double x, double y) { return 2000.0 + 600.0 * std::sin(0.31 * x + 0.1 * y) + 500.0 * std::cos(0.27 * y); }

struct Spread {
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  Eigen::Matrix2d square = Eigen::Matrix2d::Zero();
};

// Of a bright point in the middle after it went through the camera.
Spread spread_of_a_point(const SimulatorOptions& o, std::int64_t frame, int camera) {
  const auto point = drawn([](int x, int y) { return x == 64 && y == 48 ? 4000.0 : 0.0; });
  sim::RoughScratch scratch;
  const auto out = roughen(o, sim::Course(o), frame, camera, point.cview(), scratch);
  Spread s;
  double sum = 0.0;
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 128; ++x) {
      const Eigen::Vector2d p(x - 64, y - 48);
      sum += out(x, y);
      s.mean += out(x, y) * p;
      s.square += out(x, y) * p * p.transpose();
    }
  }
  s.mean /= sum;
  s.square /= sum;
  return s;
}

TEST(RoughCamera, ShakeMovesTheRightPictureByWhatIsReportedAndTheLeftNotAtAll) {
  const SimulatorOptions o = options_of("shake_px=1.2,shake_rows_px=0.4");
  const sim::Course course(o);
  const auto clean = drawn(waves);
  sim::RoughScratch scratch;
  EXPECT_EQ(roughen(o, course, 7, 0, clean.cview(), scratch).data, clean.cview().data);
  for (std::int64_t frame = 0; frame < 5; ++frame) {
    const CameraShake shake = sim::shake_of(o, frame);
    EXPECT_GT(std::abs(shake.disparity_px), 1e-3);
    const auto out = roughen(o, course, frame, 1, clean.cview(), scratch);
    for (int y = 10; y < 86; ++y) {
      for (int x = 10; x < 118; ++x) {
        // What lies at x in a steady camera is found further left by the added disparity, and lower by the rows.
        const double expected = waves(x + shake.disparity_px, y - shake.rows_px);
        ASSERT_NEAR(out(x, y), expected, 8.0) << frame << ": " << x << " " << y;
      }
    }
  }
}

TEST(RoughCamera, ShakeHasItsSigmaAndChangesSmoothlyFromFrameToFrame) {
  const SimulatorOptions o = options_of("shake_px=1.2");
  std::vector<double> all;
  double squares = 0.0;
  double products = 0.0;
  for (std::int64_t frame = 0; frame < 6000; ++frame) {
    all.push_back(sim::shake_of(o, frame).disparity_px);
    squares += all.back() * all.back();
    if (frame > 0) products += all.back() * all[all.size() - 2];
  }
  EXPECT_NEAR(std::sqrt(squares / 6000.0), 1.2, 0.1);
  const double together = products / squares;  // correlation of neighbours
  EXPECT_GT(together, 0.3);
  EXPECT_LT(together, 0.97);
  std::sort(all.begin(), all.end());
  EXPECT_NEAR(all[300], -2.0, 0.3);
  EXPECT_NEAR(all[5700], 2.0, 0.3);
}

TEST(RoughCamera, DefocusHasItsSigmaAndMovesNothing) {
  for (const double sigma : {0.8, 2.0}) {
    const Spread s = spread_of_a_point(options_of("defocus_px=" + std::to_string(sigma)), 3, 0);
    EXPECT_NEAR(s.mean.norm(), 0.0, 0.02);
    EXPECT_NEAR(s.square(0, 0), sigma * sigma, 0.08 * sigma * sigma);
    EXPECT_NEAR(s.square(1, 1), sigma * sigma, 0.08 * sigma * sigma);
    EXPECT_NEAR(s.square(0, 1), 0.0, 0.02);
  }
}

TEST(RoughCamera, VibrationBlursAlongOneLineTheSameInBothCamerasAnotherInEachFrame) {
  const SimulatorOptions o = options_of("vibration_px=16");
  double last = -1.0;
  for (std::int64_t frame = 0; frame < 6; ++frame) {
    const sim::Vibration way = sim::vibration_of(o, frame);
    const Eigen::Vector2d v(way.x_px, way.y_px);
    EXPECT_LE(v.norm(), 16.0);
    EXPECT_NE(v.norm(), last);
    last = v.norm();
    for (int camera = 0; camera < 2; ++camera) {
      const Spread s = spread_of_a_point(o, frame, camera);
      EXPECT_NEAR(s.mean.norm(), 0.0, 0.05);
      const Eigen::Matrix2d line = v * v.transpose() / 12.0;
      EXPECT_LT((s.square - line).norm(), 0.5 + 0.15 * line.norm()) << frame;
    }
  }
}

// The row that is read 30 ms later shows what a picture taken 30 ms later shows there.
TEST(RoughCamera, RollingShutterShowsEachRowAsItIsWhenItIsRead) {
  for (const char* course_name : {"wheeled", "walking,sway_deg=3"}) {
    const SimulatorOptions o =
        options_of(std::string("rate_hz=1000,step_m=0.003,rocks=0,readout_ms=96,course=") + course_name);
    const sim::Course course(o);
    const sim::World world(o, course);
    const sim::Renderer renderer(o, course, world);
    sim::RenderScratch render;
    sim::CleanPair middle;
    renderer.render(200, render, middle);
    sim::RoughScratch scratch;
    for (int camera = 0; camera < 2; ++camera) {
      const auto clean = camera == 0 ? middle.left.cview() : middle.right.cview();
      const auto rolled = roughen(o, course, 200, camera, clean, scratch);
      for (const int later : {-30, 40}) {
        sim::CleanPair then;
        renderer.render(200 + later, render, then);
        const auto expected = camera == 0 ? then.left.cview() : then.right.cview();
        const int row = 48 + later;
        double off_rolled = 0.0;
        double off_global = 0.0;
        for (int x = 20; x < 108; ++x) {
          off_rolled += std::abs(rolled(x, row) - expected(x, row));
          off_global += std::abs(clean(x, row) - expected(x, row));
        }
        EXPECT_LT(off_rolled, 0.5 * off_global) << course_name << " camera " << camera << ", " << later << " ms";
      }
    }
  }
}

TEST(RoughCamera, CompressionLeavesBlocksThatGrowAsTheQualityFalls) {
  Image<std::uint8_t> original(128, 96);
  for (int y = 0; y < 96; ++y)
    for (int x = 0; x < 128; ++x)
      original.view()(x, y) = static_cast<std::uint8_t>(std::lround(waves(2.0 * x, 1.5 * y) / 16.0) + (x * y) % 9);
  double last_off = 0.0;
  for (const int quality : {95, 50, 20}) {
    Image<std::uint8_t> image;
    image.copy_from(original.cview());
    ASSERT_TRUE(sim::through_jpeg(quality, image).ok());
    double off = 0.0;
    double at_borders = 0.0;
    double inside = 0.0;
    const auto change = [&](int x, int y) {  // of the error, from one pixel to the next
      const auto error = [&](int i) { return image.cview()(i, y) - original.cview()(i, y); };
      return std::abs(error(x) - error(x - 1));
    };
    for (int y = 0; y < 96; ++y) {
      for (int x = 8; x < 128; x += 8) {
        off += std::abs(image.cview()(x, y) - original.cview()(x, y));
        at_borders += change(x, y);
        inside += change(x - 4, y);
      }
    }
    EXPECT_GT(off, last_off) << quality;
    last_off = off;
    if (quality == 20) {
      EXPECT_GT(at_borders, 1.1 * inside);
    }
  }
}

TEST(RoughCamera, QualityStaysWithinItsSpread) {
  const SimulatorOptions o = options_of("jpeg_quality=40,jpeg_spread=10");
  int low = 100;
  int high = 0;
  for (std::int64_t frame = 0; frame < 300; ++frame) {
    for (int camera = 0; camera < 2; ++camera) {
      low = std::min(low, sim::jpeg_quality_of(o, frame, camera));
      high = std::max(high, sim::jpeg_quality_of(o, frame, camera));
    }
  }
  EXPECT_EQ(low, 30);
  EXPECT_EQ(high, 50);
  EXPECT_EQ(sim::jpeg_quality_of(options_of(""), 0, 0), 0);
}

StereoPair first_pair(const std::string& more) {
  auto source = open_simulator(options_of("frames=1,noise_sigma=0,shot_noise=off," + more));
  StereoPair pair;
  EXPECT_TRUE(source.ok() && *source.value()->next(pair));
  return pair;
}

TEST(RoughCamera, TheRightCameraAnswersAsTold) {
  const StereoPair same = first_pair("");
  const StereoPair other = first_pair("right_gain=1.2,right_bias=5,right_gamma=1.1");
  for (int y = 0; y < 96; ++y) {
    for (int x = 0; x < 128; ++x) {
      ASSERT_EQ(other.left.cview()(x, y), same.left.cview()(x, y));
      const double v = same.right.cview()(x, y);
      ASSERT_NEAR(other.right.cview()(x, y), std::min(255.0, 255.0 * 1.2 * std::pow(v / 255.0, 1.1) + 5.0), 1.6);
    }
  }
}

TEST(RoughCamera, HardSunBurnsOutAndBlackens) {
  const auto extremes = [](const StereoPair& pair, int& burnt, int& black) {
    burnt = black = 0;
    for (int y = 0; y < 96; ++y) {
      for (int x = 0; x < 128; ++x) {
        burnt += pair.left.cview()(x, y) == 255 ? 1 : 0;
        black += pair.left.cview()(x, y) == 0 ? 1 : 0;
      }
    }
  };
  int burnt = 0;
  int black = 0;
  extremes(first_pair(""), burnt, black);
  EXPECT_LT(burnt + black, 128 * 96 / 500);
  extremes(first_pair("sun_contrast=5"), burnt, black);
  EXPECT_GT(burnt, 128 * 96 / 100);
  EXPECT_GT(black, 128 * 96 / 100);
}

TEST(RoughCamera, ASetIsOverriddenByWhatIsGivenWhereverItStands) {
  const auto webcam = parse_simulator_options("camera=webcam");
  ASSERT_TRUE(webcam.ok());
  EXPECT_EQ(webcam->width, 320);
  EXPECT_EQ(webcam->height, 240);
  EXPECT_EQ(webcam->focal_px, 350.0);
  EXPECT_EQ(sim::with_camera(*webcam).jpeg_quality, 70);
  for (const char* text : {"jpeg_quality=0,width=400,camera=webcam", "camera=webcam,width=400,jpeg_quality=0"}) {
    const auto o = parse_simulator_options(text);
    ASSERT_TRUE(o.ok());
    EXPECT_EQ(o->width, 400);
    EXPECT_EQ(sim::with_camera(*o).jpeg_quality, 0);
    EXPECT_EQ(sim::with_camera(*o).defocus_px, 0.8);
  }
  const auto wrong = parse_simulator_options("camera=moon");
  ASSERT_FALSE(wrong.ok());
  EXPECT_NE(wrong.error().line().find("webcam"), std::string::npos) << wrong.error().line();
}

TEST(RoughCamera, EffectsOfTheSensorShareTheCleanCamerasRenders) {
  const std::string clean = sim::render_key(options_of(""));
  for (const char* text : {"camera=flexing", "camera=sun", "jpeg_quality=30,defocus_px=1,vibration_px=5,readout_ms=9"})
    EXPECT_EQ(sim::render_key(options_of(text)), clean) << text;
  EXPECT_NE(sim::render_key(options_of("sway_deg=1")), clean);
}

TEST(RoughCamera, PosesAndDisparitiesAreThoseOfTheCleanCamera) {
  auto clean = open_simulator(options_of("frames=2"));
  auto rough = open_simulator(options_of("frames=2,shake_px=2,readout_ms=20,vibration_px=9"));
  ASSERT_TRUE(clean.ok() && rough.ok());
  StereoPair a;
  StereoPair b;
  for (int k = 0; k < 2; ++k) {
    ASSERT_TRUE(*(*clean)->next(a) && *(*rough)->next(b));
    EXPECT_EQ(a.truth_T_world_camera->t, b.truth_T_world_camera->t);
    EXPECT_EQ(a.truth_T_world_camera->R, b.truth_T_world_camera->R);
    for (int x = 0; x < 128; ++x) EXPECT_EQ((*clean)->truth_disparity()(x, 80), (*rough)->truth_disparity()(x, 80));
    EXPECT_NE((*rough)->truth_shake().disparity_px, 0.0);
    EXPECT_EQ((*clean)->truth_shake().disparity_px, 0.0);
  }
}

}  // namespace
}  // namespace cliquevo::drivers
