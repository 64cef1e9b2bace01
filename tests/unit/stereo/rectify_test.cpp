// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/rectify.h"

#include <array>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "stereo/camera_projection.h"
#include "tests/support/test_data.h"
#include "tests/unit/stereo/as_opencv.h"

namespace cliquevo::stereo {
namespace {

using test::as_mat;
using test::as_view;
using test::data_dir;

CameraCalibration camera(int w, int h, double f, Distortion kind, std::array<double, 8> k) {
  return {w, h, f, 1.01 * f, 0.5 * w + 3.0, 0.5 * h - 2.0, kind, k};
}

cv::Mat matrix(const CameraCalibration& c) {
  return (cv::Mat_<double>(3, 3) << c.fx_px, 0, c.cx_px, 0, c.fy_px, c.cy_px, 0, 0, 1);
}

StereoCalibration crooked(Distortion kind, std::array<double, 8> k) {
  StereoCalibration c;
  c.left = camera(640, 480, 420.0, kind, k);
  c.right = camera(640, 480, 425.0, kind, k);
  c.T_right_left.R = so3_exp({0.02, -0.03, 0.015});
  c.T_right_left.t = {-0.12, 0.003, -0.002};
  return c;
}

const std::array<double, 8> kPlumbBob{-0.28, 0.07, 0.0003, -0.0002, 0.01, 0, 0, 0};
const std::array<double, 8> kRational{0.3, 0.1, 0.0003, -0.0002, 0.01, 0.62, 0.2, 0.02};
const std::array<double, 8> kFisheye{-0.02, 0.004, -0.003, 0.0005, 0, 0, 0, 0};

TEST(CameraProjection, EqualsOpenCv) {
  for (const auto& [kind, k] : {std::pair{Distortion::plumb_bob, kPlumbBob},
                                {Distortion::rational, kRational},
                                {Distortion::equidistant, kFisheye}}) {
    const CameraCalibration c = camera(640, 480, 420.0, kind, k);
    const CameraProjection projection(c);
    for (int column = -7; column <= 7; ++column) {
      for (int row = -5; row <= 5; ++row) {
        const double x = 0.1 * column;
        const double y = 0.1 * row;
        const std::vector<cv::Point3d> point{{x, y, 1.0}};
        std::vector<cv::Point2d> pixel;
        const cv::Vec3d zero(0, 0, 0);
        if (kind == Distortion::equidistant) {
          cv::fisheye::projectPoints(point, pixel, zero, zero, matrix(c), cv::Vec4d(k[0], k[1], k[2], k[3]));
        } else {
          cv::projectPoints(point, zero, zero, matrix(c), std::vector<double>(k.begin(), k.end()), pixel);
        }
        const auto p = projection.project({x, y, 1.0});
        ASSERT_TRUE(p.has_value());
        EXPECT_NEAR(p->x(), pixel[0].x, 1e-9);
        EXPECT_NEAR(p->y(), pixel[0].y, 1e-9);
        const auto back = projection.direction(p->x(), p->y());
        ASSERT_TRUE(back.has_value());
        EXPECT_NEAR(back->x(), x, 1e-8);
        EXPECT_NEAR(back->y(), y, 1e-8);
      }
    }
  }
}

TEST(CameraProjection, DoesNotShowThePictureASecondTimeWhereThePolynomialTurnsBack) {
  const CameraProjection projection(camera(640, 480, 420.0, Distortion::plumb_bob, {-0.4, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_TRUE(projection.project({0.85, 0.0, 1.0}).has_value());
  EXPECT_FALSE(projection.project({1.5, 0.0, 1.0}).has_value());  // would land inside the image again
  EXPECT_FALSE(projection.project({0.0, 0.0, -1.0}).has_value());
}

// A point seen by both raw cameras must come to one row, at the disparity that triangulates to its depth.
TEST(Rectifier, OwnRectificationBringsAPointToOneRowAtItsDisparity) {
  for (const auto& [kind, k] : {std::pair{Distortion::none, std::array<double, 8>{}},
                                {Distortion::plumb_bob, kPlumbBob},
                                {Distortion::rational, kRational},
                                {Distortion::equidistant, kFisheye}}) {
    const StereoCalibration c = crooked(kind, k);
    auto rectifier = Rectifier::make(c);
    ASSERT_TRUE(rectifier.ok()) << rectifier.error().line();
    const StereoModel& m = rectifier->model();
    ASSERT_TRUE(m.check().ok());
    EXPECT_NEAR(m.baseline_m, c.T_right_left.t.norm(), 1e-12);
    EXPECT_EQ(m.doffs_px, 0.0);
    // Paint a small blob at each camera's raw projection and look for its centroid in the rectified images.
    for (const Eigen::Vector3d& P :
         {Eigen::Vector3d(0.1, 0.05, 2.0), Eigen::Vector3d(-0.4, -0.3, 1.5), Eigen::Vector3d(0.3, 0.2, 1.2)}) {
      std::array<Eigen::Vector2d, 2> centroid;
      for (const CameraSide side : {CameraSide::left, CameraSide::right}) {
        const CameraCalibration& raw_camera = side == CameraSide::left ? c.left : c.right;
        const auto p = CameraProjection(raw_camera).project(side == CameraSide::left ? P : c.T_right_left * P);
        ASSERT_TRUE(p.has_value());
        Image<std::uint8_t> raw(640, 480), out(m.width, m.height);
        for (int y = 0; y < 480; ++y) {
          for (int x = 0; x < 640; ++x) {
            const double r2 = (x - p->x()) * (x - p->x()) + (y - p->y()) * (y - p->y());
            raw.view()(x, y) = static_cast<std::uint8_t>(std::lround(250.0 * std::exp(-r2 / 18.0)));
          }
        }
        ASSERT_TRUE(rectifier->rectify(side, raw.view(), out.view()).ok());
        double sum = 0.0;
        Eigen::Vector2d mean(0, 0);
        for (int y = 0; y < m.height; ++y) {
          for (int x = 0; x < m.width; ++x) {
            sum += out.view()(x, y);
            mean += out.view()(x, y) * Eigen::Vector2d(x, y);
          }
        }
        centroid[side == CameraSide::right] = mean / sum;
      }
      EXPECT_NEAR(centroid[0].y(), centroid[1].y(), 0.05);
      const Eigen::Vector3d seen = m.triangulate(centroid[0].x(), centroid[0].y(), centroid[0].x() - centroid[1].x());
      EXPECT_NEAR(seen.norm(), P.norm(), 0.02 * P.norm());
    }
  }
}

TEST(Rectifier, OwnRectificationOfALevelPairLeavesNoBordersAndKeepsThePixelsSize) {
  for (const auto& [kind, k] : {std::pair{Distortion::none, std::array<double, 8>{}},
                                {Distortion::plumb_bob, kPlumbBob},
                                {Distortion::equidistant, kFisheye}}) {
    StereoCalibration c = crooked(kind, k);
    c.T_right_left.R.setIdentity();
    c.T_right_left.t = {-0.12, 0.0, 0.0};
    c.right = c.left;
    auto rectifier = Rectifier::make(c);
    ASSERT_TRUE(rectifier.ok());
    const StereoModel& m = rectifier->model();
    EXPECT_GE(m.fx_px, 0.74 * c.left.fx_px);
    EXPECT_LE(m.fx_px, 1.1 * c.left.fx_px);
    Image<std::uint8_t> raw(640, 480), out(m.width, m.height);
    raw.fill(200);
    for (const CameraSide side : {CameraSide::left, CameraSide::right}) {
      ASSERT_TRUE(rectifier->rectify(side, raw.view(), out.view()).ok());
      for (int y = 0; y < m.height; ++y) {
        for (int x = 0; x < m.width; ++x) ASSERT_EQ(out.view()(x, y), 200) << x << "," << y;
      }
    }
  }
}

TEST(Rectifier, MaskFollowsTheImage) {
  const StereoCalibration c = crooked(Distortion::plumb_bob, kPlumbBob);
  auto rectifier = Rectifier::make(c);
  ASSERT_TRUE(rectifier.ok());
  const StereoModel& m = rectifier->model();
  Image<std::uint8_t> raw(640, 480), out(m.width, m.height), mask(m.width, m.height);
  for (int y = 0; y < 480; ++y) {
    for (int x = 0; x < 640; ++x) raw.view()(x, y) = y < 300 ? 255 : 0;
  }
  ASSERT_TRUE(rectifier->rectify(CameraSide::left, raw.view(), out.view()).ok());
  ASSERT_TRUE(rectifier->rectify_mask(CameraSide::left, raw.view(), mask.view()).ok());
  for (int y = 0; y < m.height; ++y) {
    for (int x = 0; x < m.width; ++x) {
      ASSERT_TRUE(mask.view()(x, y) == 0 || mask.view()(x, y) == 255);
      if (out.view()(x, y) == 255 || out.view()(x, y) == 0) {
        ASSERT_EQ(mask.view()(x, y), out.view()(x, y));
      }
    }
  }
}

TEST(Rectifier, NamesWhatCannotBe) {
  const auto fails = [](void (*spoil)(StereoCalibration&)) {
    StereoCalibration c = crooked(Distortion::plumb_bob, kPlumbBob);
    spoil(c);
    auto r = Rectifier::make(c);
    return !r.ok() && !r.error().what.empty() && !r.error().where.empty() && !r.error().remedy.empty();
  };
  EXPECT_TRUE(fails([](StereoCalibration& c) { c.left.fx_px = 0.0; }));
  EXPECT_TRUE(fails([](StereoCalibration& c) { c.right.fy_px = -400.0; }));
  EXPECT_TRUE(fails([](StereoCalibration& c) { c.left.cx_px = std::numeric_limits<double>::quiet_NaN(); }));
  EXPECT_TRUE(fails([](StereoCalibration& c) { c.left.coefficients[1] = std::numeric_limits<double>::infinity(); }));
  EXPECT_TRUE(fails([](StereoCalibration& c) { c.left.width = 0; }));
  EXPECT_TRUE(fails([](StereoCalibration& c) { c.T_right_left.R.setZero(); }));
  EXPECT_TRUE(fails([](StereoCalibration& c) { c.T_right_left.R.row(0) *= -1.0; }));
  EXPECT_TRUE(fails([](StereoCalibration& c) { c.T_right_left.t.setZero(); }));
  EXPECT_TRUE(fails([](StereoCalibration& c) { c.T_right_left.t.x() = 0.12; }));  // swapped
  EXPECT_TRUE(fails([](StereoCalibration& c) { c.T_right_left.t = {0, -0.1, 0}; }));
  EXPECT_TRUE(fails([](StereoCalibration& c) { c.T_right_left.R = so3_exp({0, 1.5, 0}); }));
  EXPECT_TRUE(fails([](StereoCalibration& c) {
    c.prescribed = PrescribedRectification{};
    c.prescribed->model = {640, 480, 420, 420, 5000, 240, 0.12, 0.0};  // looks past the image
  }));
}

TEST(Rectifier, WrongSizesAreRefused) {
  auto rectifier = Rectifier::make(crooked(Distortion::plumb_bob, kPlumbBob));
  ASSERT_TRUE(rectifier.ok());
  Image<std::uint8_t> raw(640, 480), small(320, 240);
  EXPECT_FALSE(rectifier->rectify(CameraSide::left, small.view(), raw.view()).ok());
  EXPECT_FALSE(rectifier->rectify(CameraSide::left, raw.view(), small.view()).ok());
  EXPECT_FALSE(rectifier->rectify(CameraSide::left, {}, raw.view()).ok());
}

TEST(Rectifier, CopiesAnImageThatAlreadyIsRectified) {
  StereoCalibration c;
  c.rectified = true;
  c.prescribed = PrescribedRectification{};
  c.prescribed->model = {64, 48, 50, 50, 32, 24, 0.1, 0.0};
  auto rectifier = Rectifier::make(c);
  ASSERT_TRUE(rectifier.ok());
  EXPECT_TRUE(rectifier->is_identity());
  Image<std::uint8_t> raw(64, 48), out(64, 48);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) raw.view()(x, y) = static_cast<std::uint8_t>(x * 3 + y);
  }
  ASSERT_TRUE(rectifier->rectify(CameraSide::right, raw.view(), out.view()).ok());
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) ASSERT_EQ(raw.view()(x, y), out.view()(x, y));
  }
}

std::vector<double> numbers(const std::string& file, const std::string& key) {
  std::ifstream in(file);
  std::vector<double> out;
  for (std::string line; std::getline(in, line);) {
    if (line.rfind(key + ":", 0) != 0) continue;
    std::istringstream words(line.substr(key.size() + 1));
    for (double v = 0.0; words >> v;) out.push_back(v);
  }
  return out;
}

StereoCalibration kitti_raw() {
  const std::string file = data_dir() + "/kitti_raw/calib_cam_to_cam.txt";
  StereoCalibration c;
  for (int side = 0; side < 2; ++side) {
    const std::string n = "_0" + std::to_string(side);
    CameraCalibration& cam = side == 0 ? c.left : c.right;
    const auto S = numbers(file, "S" + n);
    const auto K = numbers(file, "K" + n);
    const auto D = numbers(file, "D" + n);
    cam = {static_cast<int>(S[0]), static_cast<int>(S[1]), K[0], K[4], K[2], K[5], Distortion::plumb_bob, {}};
    std::copy(D.begin(), D.end(), cam.coefficients.begin());
  }
  c.T_right_left.R = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers(file, "R_01").data());
  c.T_right_left.t = Eigen::Map<const Eigen::Vector3d>(numbers(file, "T_01").data());
  PrescribedRectification p;
  p.R_left = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers(file, "R_rect_00").data());
  p.R_right = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(numbers(file, "R_rect_01").data());
  const auto P0 = numbers(file, "P_rect_00");
  const auto P1 = numbers(file, "P_rect_01");
  p.model = {1242, 375, P0[0], P0[5], P0[2], P0[6], (P0[3] - P1[3]) / P0[0], P1[2] - P0[2]};
  c.prescribed = p;
  return c;
}

TEST(Rectifier, PrescribedRectificationOfKittiEqualsOpenCvsToAGreyLevel) {
  CLIQUEVO_NEEDS_DATA("kitti_raw");
  const StereoCalibration c = kitti_raw();
  auto rectifier = Rectifier::make(c);
  ASSERT_TRUE(rectifier.ok()) << rectifier.error().line();
  const StereoModel& m = rectifier->model();
  EXPECT_EQ(m.width, 1242);
  EXPECT_EQ(m.height, 375);
  EXPECT_NEAR(m.baseline_m, 0.5372, 1e-4);
  for (const CameraSide side : {CameraSide::left, CameraSide::right}) {
    const std::string folder = data_dir() + "/kitti_raw/image_0" + (side == CameraSide::left ? "0" : "1") + "/data";
    std::vector<cv::String> files;
    cv::glob(folder + "/*.png", files);
    ASSERT_FALSE(files.empty());
    const cv::Mat raw = cv::imread(files[0], cv::IMREAD_GRAYSCALE);
    const CameraCalibration& cam = side == CameraSide::left ? c.left : c.right;
    const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R =
        side == CameraSide::left ? c.prescribed->R_left : c.prescribed->R_right;
    const cv::Mat R_cv(3, 3, CV_64F, const_cast<double*>(R.data()));
    const cv::Mat P = (cv::Mat_<double>(3, 3) << m.fx_px, 0, m.cx_px, 0, m.fy_px, m.cy_px, 0, 0, 1);
    cv::Mat map_x, map_y, expected;
    cv::initUndistortRectifyMap(matrix(cam),
                                std::vector<double>(cam.coefficients.begin(), cam.coefficients.begin() + 5), R_cv, P,
                                {m.width, m.height}, CV_32FC1, map_x, map_y);
    cv::remap(raw, expected, map_x, map_y, cv::INTER_LINEAR);
    Image<std::uint8_t> out(m.width, m.height);
    ASSERT_TRUE(rectifier->rectify(side, as_view(raw), out.view()).ok());
    cv::Mat difference;
    cv::absdiff(as_mat(out), expected, difference);
    EXPECT_LT(cv::mean(difference)[0], 0.5);
    double worst = 0.0;
    cv::minMaxLoc(difference, nullptr, &worst);
    EXPECT_LE(worst, 10.0);  // OpenCV samples at 1/32 px, this at 1/64 px
  }
}

}  // namespace
}  // namespace cliquevo::stereo
