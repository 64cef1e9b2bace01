// SPDX-License-Identifier: BSD-3-Clause
// Every lens model projects as its authors wrote it and finds the direction again.
#include <cmath>

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

#include "stereo/camera_projection.h"
#include "stereo/rectify.h"

namespace cliquevo::stereo {
namespace {

CameraCalibration camera(Distortion model, std::array<double, 8> k, double f = 300.0,
                         std::array<double, 6> prism = {}) {
  return {640, 480, f, f + 1.0, 321.5, 239.0, model, k, prism};
}

const CameraCalibration kCameras[] = {
    camera(Distortion::none, {}),
    camera(Distortion::plumb_bob, {-0.28, 0.07, 2e-4, -3e-4}),
    camera(Distortion::rational, {0.1, 0.02, 1e-4, 2e-4, 0.01, 0.3, 0.05, 0.001}),
    camera(Distortion::thin_prism, {0.1, 0.02, 1e-4, 2e-4, 0.01, 0.3, 0.05, 0.001}, 300.0,
           {1e-3, 2e-4, -1e-3, 3e-4, 0.01, -0.02}),
    camera(Distortion::equidistant, {-0.003, 0.054, -0.051, 0.0107}),
    camera(Distortion::unified, {0.9, -0.1, 0.02, 1e-3, -2e-3}, 560.0),
    camera(Distortion::unified, {2.1, -0.2, 0.5, 1e-3, -2e-3}, 900.0),
    camera(Distortion::extended_unified, {0.6, 1.1}),
    camera(Distortion::extended_unified, {0.4, 0.9}),
    camera(Distortion::double_sphere, {-0.18, 0.59}, 230.0),
    camera(Distortion::double_sphere, {0.3, 0.4}, 400.0),
};

TEST(lens_models, direction_and_pixel_lead_back_to_each_other) {
  for (const CameraCalibration& c : kCameras) {
    SCOPED_TRACE(static_cast<int>(c.distortion));
    const CameraProjection projection(c);
    EXPECT_TRUE(projection.is_plausible());
    int found = 0;
    for (int v = 60; v <= 420; v += 40) {
      for (int u = 80; u <= 560; u += 40) {
        const auto d = projection.direction(u, v);
        if (!d) continue;
        ++found;
        const auto p = projection.project(3.7 * *d);
        ASSERT_TRUE(p);
        EXPECT_NEAR(p->x(), u, 1e-6);
        EXPECT_NEAR(p->y(), v, 1e-6);
      }
    }
    EXPECT_GT(found, 100);
  }
}

TEST(lens_models, double_sphere_and_its_relatives_by_their_formulas) {
  const Eigen::Vector3d d(0.4, -0.3, 1.0);
  {
    const CameraCalibration c = camera(Distortion::double_sphere, {-0.18, 0.59}, 230.0);
    const double d1 = d.norm();
    const double z = -0.18 * d1 + d.z();
    const double m = 0.59 * std::sqrt(d.x() * d.x() + d.y() * d.y() + z * z) + 0.41 * z;
    const auto p = CameraProjection(c).project(d);
    ASSERT_TRUE(p);
    EXPECT_NEAR(p->x(), c.fx_px * d.x() / m + c.cx_px, 1e-9);
    EXPECT_NEAR(p->y(), c.fy_px * d.y() / m + c.cy_px, 1e-9);
  }
  {
    const CameraCalibration c = camera(Distortion::extended_unified, {0.6, 1.1});
    const double m = 0.6 * std::sqrt(1.1 * (d.x() * d.x() + d.y() * d.y()) + 1.0) + 0.4;
    EXPECT_NEAR(CameraProjection(c).project(d)->x(), c.fx_px * d.x() / m + c.cx_px, 1e-9);
  }
  {
    const CameraCalibration c = camera(Distortion::unified, {0.9, -0.1, 0.02, 1e-3, -2e-3}, 560.0);
    const Eigen::Vector3d s = d.normalized();
    const double x = s.x() / (s.z() + 0.9);
    const double y = s.y() / (s.z() + 0.9);
    const double r2 = x * x + y * y;
    const double radial = 1.0 - 0.1 * r2 + 0.02 * r2 * r2;
    const auto p = CameraProjection(c).project(d);
    ASSERT_TRUE(p);
    EXPECT_NEAR(p->x(), c.fx_px * (x * radial + 2e-3 * x * y - 2e-3 * (r2 + 2 * x * x)) + c.cx_px, 1e-9);
    EXPECT_NEAR(p->y(), c.fy_px * (y * radial + 1e-3 * (r2 + 2 * y * y) - 4e-3 * x * y) + c.cy_px, 1e-9);
  }
}

TEST(lens_models, thin_prism_and_tilt_as_opencv) {
  const CameraCalibration& c = kCameras[3];
  const cv::Matx33d K(c.fx_px, 0, c.cx_px, 0, c.fy_px, c.cy_px, 0, 0, 1);
  std::vector<double> D(c.coefficients.begin(), c.coefficients.end());
  D.insert(D.end(), c.prism.begin(), c.prism.end());
  for (const Eigen::Vector3d& d :
       {Eigen::Vector3d(0.5, 0.2, 1), Eigen::Vector3d(-0.6, 0.4, 1), Eigen::Vector3d(0, 0, 2)}) {
    std::vector<cv::Point2d> out;
    cv::projectPoints(std::vector<cv::Point3d>{{d.x(), d.y(), d.z()}}, cv::Vec3d(), cv::Vec3d(), K, D, out);
    const auto p = CameraProjection(c).project(d);
    ASSERT_TRUE(p);
    EXPECT_NEAR(p->x(), out[0].x, 1e-9);
    EXPECT_NEAR(p->y(), out[0].y, 1e-9);
  }
}

TEST(lens_models, spheres_end_where_they_see_nothing) {
  for (const CameraCalibration& c : kCameras) {
    const CameraProjection projection(c);
    EXPECT_FALSE(projection.project({0.0, 0.0, -1.0})) << static_cast<int>(c.distortion);
    EXPECT_FALSE(projection.project({0.0, 0.0, 0.0}).has_value() && c.distortion == Distortion::none);
    const auto far = projection.direction(1e7, 1e7);
    EXPECT_TRUE(!far || far->allFinite());
  }
}

TEST(lens_models, a_pair_of_each_can_be_rectified) {
  for (const CameraCalibration& c : kCameras) {
    StereoCalibration rig;
    rig.left = rig.right = c;
    rig.T_right_left = {so3_exp({0.005, -0.01, 0.003}), {-0.1, 0.001, 0.001}};
    const auto rectifier = Rectifier::make(rig);
    ASSERT_TRUE(rectifier.ok()) << static_cast<int>(c.distortion) << rectifier.error().line();
    EXPECT_GT(rectifier->model().fx_px, 100.0);
    EXPECT_LT(rectifier->model().fx_px, 500.0);
  }
}

TEST(lens_models, that_no_lens_can_be_is_told) {
  for (const CameraCalibration& c :
       {camera(Distortion::equidistant, {1000.0}), camera(Distortion::equidistant, {0.0, 1000.0}),
        camera(Distortion::equidistant, {-5.0}), camera(Distortion::plumb_bob, {-5.0}),
        camera(Distortion::plumb_bob, {-0.3, 0.1, 3.0}), camera(Distortion::rational, {0, 0, 0, 0, 0, 500.0})}) {
    EXPECT_FALSE(CameraProjection(c).is_plausible()) << static_cast<int>(c.distortion) << " " << c.coefficients[0];
  }
}

}  // namespace
}  // namespace cliquevo::stereo
