// SPDX-License-Identifier: BSD-3-Clause
// Rectified pairs of another size and field of view.
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "stereo/camera_projection.h"
#include "stereo/rectification.h"
#include "stereo/rectify.h"

namespace cliquevo::stereo {
namespace {

constexpr double kDegree = M_PI / 180.0;

CameraCalibration camera(int w, int h, double f, Distortion kind, std::array<double, 8> k) {
  return {w, h, f, f, 0.5 * w + 3.0, 0.5 * h - 2.0, kind, k};
}

StereoCalibration crooked() {
  StereoCalibration c;
  c.left = camera(640, 480, 420.0, Distortion::plumb_bob, {-0.28, 0.07, 0.0003, -0.0002, 0.01, 0, 0, 0});
  c.right = camera(640, 480, 425.0, Distortion::plumb_bob, {-0.28, 0.07, 0.0003, -0.0002, 0.01, 0, 0, 0});
  c.T_right_left.R = so3_exp({0.02, -0.03, 0.015});
  c.T_right_left.t = {-0.12, 0.003, -0.002};
  return c;
}

StereoCalibration level() {
  StereoCalibration c;
  c.rectified = true;
  c.left = camera(640, 480, 400.0, Distortion::none, {});
  c.right = c.left;
  c.prescribed.emplace();
  c.prescribed->model = {640, 480, 400.0, 400.0, 321.0, 238.0, 0.12, 4.0};
  return c;
}

// A lens of 190 degrees whose circle fills the sensor's width.
StereoCalibration fisheye() {
  StereoCalibration c;
  c.left = camera(1280, 960, 1280 / (190.0 * kDegree), Distortion::equidistant, {});
  c.right = c.left;
  c.T_right_left.t = {-0.1, 0.0, 0.0};
  return c;
}

RectifyParams params(double scale) {
  RectifyParams out;
  out.scale = scale;
  return out;
}

// Where a wide blob at a point's raw projection ends up in the rectified image.
Eigen::Vector2d centroid(const Rectifier& rectifier, CameraSide side, const CameraCalibration& raw_camera,
                         const Eigen::Vector3d& point) {
  const auto p = CameraProjection(raw_camera).project(point);
  EXPECT_TRUE(p.has_value());
  Image<std::uint8_t> raw(raw_camera.width, raw_camera.height);
  Image<std::uint8_t> out(rectifier.model().width, rectifier.model().height);
  for (int y = 0; y < raw.height(); ++y) {
    for (int x = 0; x < raw.width(); ++x) {
      const double r2 = (x - p->x()) * (x - p->x()) + (y - p->y()) * (y - p->y());
      raw.view()(x, y) = static_cast<std::uint8_t>(std::lround(250.0 * std::exp(-r2 / 60.0)));
    }
  }
  EXPECT_TRUE(rectifier.rectify(side, raw.cview(), out.view()).ok());
  double sum = 0.0;
  Eigen::Vector2d mean(0, 0);
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      sum += out.view()(x, y);
      mean += out.view()(x, y) * Eigen::Vector2d(x, y);
    }
  }
  return mean / sum;
}

TEST(RectifiedScale, APointStaysOnOneRowAtTheDisparityOfTheSmallerModel) {
  for (const bool raw : {true, false}) {
    const StereoCalibration c = raw ? crooked() : level();
    for (const double scale : {1.5, 0.8, 0.5, 0.37, 0.25}) {
      const auto rectifier = Rectifier::make(c, params(scale));
      ASSERT_TRUE(rectifier.ok()) << rectifier.error().line();
      EXPECT_FALSE(rectifier->is_identity());
      const StereoModel& m = rectifier->model();
      EXPECT_EQ(m.width, std::lround(640 * scale));
      EXPECT_EQ(m.height, std::lround(480 * scale));
      const Eigen::Vector3d point(0.1, 0.05, 2.0);
      CameraCalibration left = c.left;
      CameraCalibration right = c.right;
      Eigen::Vector3d seen_right = c.T_right_left * point;
      Eigen::Vector3d rectified = point;
      if (!raw) {
        left.cx_px = 321.0;
        left.cy_px = right.cy_px = 238.0;
        right.cx_px = 325.0;
        seen_right = point - Eigen::Vector3d(0.12, 0, 0);
      } else {
        rectified = choose_rectification(c)->R_left * point;
      }
      const Eigen::Vector2d l = centroid(*rectifier, CameraSide::left, left, point);
      const Eigen::Vector2d r = centroid(*rectifier, CameraSide::right, right, seen_right);
      EXPECT_NEAR(l.y(), r.y(), 0.06) << scale;
      const Eigen::Vector3d found = m.triangulate(l.x(), l.y(), l.x() - r.x());
      EXPECT_NEAR(found.z(), rectified.z(), 0.02) << scale << (raw ? " raw" : " rectified");
      EXPECT_NEAR(found.x(), rectified.x(), 0.002) << scale;
      EXPECT_NEAR(found.y(), rectified.y(), 0.002) << scale;
    }
  }
}

TEST(RectifiedScale, TheNativeSizeIsWhatItWasWithoutIt) {
  for (const StereoCalibration& c : {crooked(), level()}) {
    const auto before = Rectifier::make(c);
    const auto after = Rectifier::make(c, params(1.0));
    ASSERT_TRUE(before.ok() && after.ok());
    EXPECT_EQ(after->is_identity(), c.rectified);
    EXPECT_EQ(after->model().fx_px, before->model().fx_px);
    EXPECT_EQ(after->model().cx_px, before->model().cx_px);
    EXPECT_EQ(after->model().width, before->model().width);
  }
}

// Stripes of two pixels a period are grey from afar. Sampling every other pixel would show them black or white.
TEST(RectifiedScale, FineTextureDoesNotAliasAtHalfTheSizeAndBelow) {
  for (const double scale : {0.5, 0.4, 0.25, 0.125}) {
    const auto rectifier = Rectifier::make(level(), params(scale));
    ASSERT_TRUE(rectifier.ok());
    Image<std::uint8_t> raw(640, 480);
    Image<std::uint8_t> out(rectifier->model().width, rectifier->model().height);
    for (int y = 0; y < 480; ++y) {
      for (int x = 0; x < 640; ++x) raw.view()(x, y) = (x + y) % 2 == 0 ? 200 : 100;
    }
    ASSERT_TRUE(rectifier->rectify(CameraSide::left, raw.cview(), out.view()).ok());
    for (int y = 2; y < out.height() - 2; ++y) {
      for (int x = 2; x < out.width() - 2; ++x) ASSERT_NEAR(out.view()(x, y), 150, 1) << scale;
    }
  }
}

TEST(RectifiedScale, AMaskedRawPixelMasksEveryRectifiedOneThatItIsIn) {
  const auto rectifier = Rectifier::make(level(), params(0.25));
  ASSERT_TRUE(rectifier.ok());
  Image<std::uint8_t> raw(640, 480);
  raw.fill(255);
  raw.view()(321, 242) = 0;
  Image<std::uint8_t> out(rectifier->model().width, rectifier->model().height);
  ASSERT_TRUE(rectifier->rectify_mask(CameraSide::left, raw.cview(), out.view()).ok());
  EXPECT_EQ(out.view()(80, 60), 0);
  EXPECT_EQ(out.view()(20, 20), 255);
}

TEST(RectifiedFov, TheHorizontalFieldOfViewIsTheOneAskedFor) {
  for (const StereoCalibration& c : {crooked(), level(), fisheye()}) {
    for (const double fov_deg : {40.0, 60.0, 70.0}) {
      RectifyParams asked;
      asked.fov_deg = fov_deg;
      asked.scale = 0.5;
      const auto rectifier = Rectifier::make(c, asked);
      ASSERT_TRUE(rectifier.ok()) << rectifier.error().line();
      const StereoModel& m = rectifier->model();
      // Between the outer edges of the native size's outer pixels' middles.
      StereoModel native = m;
      native.width = c.left.width;
      native.fx_px = 2.0 * m.fx_px;
      native.cx_px = 2.0 * (m.cx_px + 0.5) - 0.5;
      EXPECT_NEAR(native.horizontal_fov_rad() / kDegree, fov_deg, 1e-6);
      EXPECT_EQ(m.width, c.left.width / 2);
    }
  }
}

TEST(RectifiedFov, AFisheyeOf190DegreesBecomesAPictureThatIsNotMostlyStretchedRim) {
  const auto native = choose_rectification(fisheye());
  ASSERT_TRUE(native.ok()) << native.error().line();
  EXPECT_NEAR(native->model.horizontal_fov_rad() / kDegree, RectifyParams::kMostFovDeg, 0.5);
  RectifyParams wide;
  wide.fov_deg = 150.0;
  const auto asked = Rectifier::make(fisheye(), wide);
  ASSERT_TRUE(asked.ok()) << asked.error().line();
  EXPECT_NEAR(asked->model().horizontal_fov_rad() / kDegree, 150.0, 1e-6);
}

TEST(RectifyParams, WhatCannotBeIsRefused) {
  const double nan = std::nan("");
  for (const double scale : {0.0, -1.0, 0.049, 2.01, nan, 1e300}) EXPECT_FALSE(params(scale).check().ok()) << scale;
  for (const double fov_deg : {0.0, 9.9, 150.1, 190.0, nan, -60.0}) {
    RectifyParams p;
    p.fov_deg = fov_deg;
    EXPECT_FALSE(p.check().ok()) << fov_deg;
    EXPECT_FALSE(Rectifier::make(level(), p).ok()) << fov_deg;
  }
  StereoCalibration small = level();
  small.prescribed->model.width = 100;
  small.prescribed->model.height = 100;
  small.prescribed->model.cx_px = small.prescribed->model.cy_px = 50.0;
  EXPECT_FALSE(Rectifier::make(small, params(0.1)).ok());  // 10 pixels
}

}  // namespace
}  // namespace cliquevo::stereo
