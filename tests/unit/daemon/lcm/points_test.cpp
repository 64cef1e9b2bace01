// SPDX-License-Identifier: BSD-3-Clause
// VO_POINTS: where points of a disparity lie, how uncertain they are, which are left out; and the thread that sends
// them.
#include "daemon/lcm/points.h"

#include <chrono>
#include <cmath>
#include <thread>

#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>

#include "daemon/points_thread.h"
#include "tests/support/test_data.h"
#include "tests/unit/daemon/lcm/made_up_frames.h"

namespace cliquevo::daemon {
namespace {

constexpr int kStep = 4;

StereoModel model() {
  StereoModel m;
  m.width = 64;
  m.height = 48;
  m.fx_px = 80.0;
  m.fy_px = 90.0;
  m.cx_px = 31.0;
  m.cy_px = 22.0;
  m.baseline_m = 0.2;
  m.doffs_px = 0.5;
  return m;
}

// disparity: px * 16
TappedImages images(std::uint16_t disparity) {
  TappedImages out;
  out.stamp_ns = 1'700'000'000'123'456'789;
  out.left.resize(model().width, model().height);
  out.disparity.resize(model().width, model().height);
  out.disparity.fill(disparity);
  for (int y = 0; y < model().height; ++y) {
    for (int x = 0; x < model().width; ++x) out.left.view()(x, y) = static_cast<std::uint8_t>(x + 2 * y);
  }
  return out;
}

points_t points_of(const TappedImages& from, const RigidTransform& T_body_camera = forward_camera(), int step = kStep) {
  points_t out{};
  build_points(from, model(), T_body_camera, step, out);
  EXPECT_EQ(static_cast<std::size_t>(out.num_points), out.x.size());
  for (const auto* list : {&out.y, &out.z, &out.sigma}) EXPECT_EQ(list->size(), out.x.size());
  EXPECT_EQ(out.grey.size(), out.x.size());
  return out;
}

// In the camera's frame.
Eigen::Vector3d seen(const points_t& m, std::size_t i, const RigidTransform& T_body_camera) {
  return T_body_camera.inverse() * Eigen::Vector3d(m.x[i], m.y[i], m.z[i]);
}

TEST(Points, AWallStandsWhereItsDisparityPutsItInTheBodyFrame) {
  const TappedImages wall = images(10 * 16);
  const points_t m = points_of(wall);
  EXPECT_EQ(m.utime, 1'700'000'000'123'456);
  EXPECT_EQ(m.step_px, kStep);
  ASSERT_EQ(m.num_points, (64 / kStep) * (48 / kStep));
  const double depth_m = 80.0 * 0.2 / 10.5;
  for (std::size_t i = 0; i < m.x.size(); ++i) {
    EXPECT_NEAR(m.x[i], 0.3 + depth_m, 1e-5) << "the camera looks along the body's x, 0.3 m ahead of its origin";
    const Eigen::Vector3d pixel = model().project(seen(m, i, forward_camera()));
    EXPECT_NEAR(pixel.x(), std::round(pixel.x()), 1e-3);
    EXPECT_NEAR(pixel.y(), std::round(pixel.y()), 1e-3);
    EXPECT_EQ(m.grey[i], std::lround(pixel.x()) + 2 * std::lround(pixel.y()));
    // What is left in the image is left of the body, what is above is above.
    EXPECT_EQ(m.y[i] > 0.0F, pixel.x() < model().cx_px - 0.5) << pixel.x();
    EXPECT_EQ(m.z[i] > 0.5F, pixel.y() < model().cy_px - 0.5) << pixel.y();
  }
  for (int i = 0; i < 3; ++i) EXPECT_EQ(m.camera_position[i], forward_camera().t[i]);
}

TEST(Points, SigmaIsWhatASigmaOfDisparityMovesThePointAlongItsRay) {
  for (const double disparity_px : {4.0, 10.0, 40.0}) {
    const points_t m = points_of(images(static_cast<std::uint16_t>(16 * disparity_px)));
    ASSERT_FALSE(m.x.empty());
    for (std::size_t i = 0; i < m.x.size(); ++i) {
      const Eigen::Vector3d p = seen(m, i, forward_camera());
      const Eigen::Vector3d pixel = model().project(p);
      constexpr double kSmall = 1e-3;  // of a sigma: to first order
      const Eigen::Vector3d moved =
          model().triangulate(pixel.x(), pixel.y(), disparity_px + kSmall * kDisparitySigma_px);
      EXPECT_NEAR(m.sigma[i], (moved - p).norm() / kSmall, 2e-2 * m.sigma[i]);
      EXPECT_NEAR((moved - p).normalized().dot(p.normalized()), -1.0, 1e-3);
    }
  }
}

TEST(Points, NoPointHangsBetweenTwoSurfaces) {
  TappedImages scene = images(8 * 16);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 30; ++x) scene.disparity.view()(x, y) = 24 * 16;  // ends within a square
  }
  const points_t m = points_of(scene);
  ASSERT_EQ(m.num_points, (64 / kStep) * (48 / kStep));
  for (std::size_t i = 0; i < m.x.size(); ++i) {
    const Eigen::Vector3d pixel = model().project(seen(m, i, forward_camera()));
    const double expected_px = pixel.x() < 29.5 ? 24.0 : 8.0;
    EXPECT_NEAR(pixel.z(), expected_px, 1e-3) << "at " << pixel.x();
  }
}

TEST(Points, SquaresOfWhichLittleIsKnownAndWhatIsTooFarToTellAreLeftOut) {
  TappedImages scene = images(0);
  EXPECT_EQ(points_of(scene).num_points, 0);
  int known = 0;
  for (int y = 0; y < kStep; ++y) {
    for (int x = 0; x < kStep; ++x) {
      if (known++ < kStep * kStep / 2 - 1) scene.disparity.view()(x, y) = 160;
    }
  }
  EXPECT_EQ(points_of(scene).num_points, 0);
  scene.disparity.view()(kStep - 1, kStep - 1) = 160;
  EXPECT_EQ(points_of(scene).num_points, 1);
  // Sigma is a quarter of the depth where the disparity, doffs included, is four sigmas.
  const double least_px = 4.0 * kDisparitySigma_px - model().doffs_px;
  EXPECT_EQ(points_of(images(static_cast<std::uint16_t>(16.0 * least_px))).num_points, 0);
  EXPECT_GT(points_of(images(static_cast<std::uint16_t>(16.0 * least_px) + 1)).num_points, 0);
}

TEST(Points, ImagesThatTheSquaresDoNotDivideAreCoveredToTheirEdges) {
  EXPECT_EQ(points_of(images(160), forward_camera(), 1).num_points, 64 * 48);
  EXPECT_EQ(points_of(images(160), forward_camera(), 7).num_points, 10 * 7);
  EXPECT_EQ(points_of(images(160), forward_camera(), 64).num_points, 1);
}

LcmConfig to_log(const std::string& path) {
  LcmConfig config;
  config.url = "file://" + path + "?mode=w";
  config.points_channel = "VO_POINTS";
  config.points_rate_hz = 1000.0;
  return config;
}

TEST(PointsThread, IsNoneWhereNobodyAskedForPoints) {
  const auto none = PointsThread::start(LcmConfig{}, model(), forward_camera());
  ASSERT_TRUE(none.ok());
  EXPECT_EQ(*none, nullptr);
}

// Of frames that come faster than it works some are left out; those that go out are whole, in order, and copied once.
TEST(PointsThread, SendsWhatItWasGivenInOrderAndHoldsNobodyUp) {
  const std::string path = test::scratch_dir() + "/points.log";
  int copied = 0;
  constexpr int kFrames = 300;
  {
    const LcmConfig config = to_log(path);
    auto publisher = Publisher::make(config, forward_camera());
    ASSERT_TRUE(publisher.ok());
    publisher->copy_to([&](const std::string& channel, const std::uint8_t*, std::size_t size) {
      EXPECT_EQ(channel, "VO_POINTS");
      EXPECT_GT(size, 1000U);
      ++copied;
    });
    auto points = PointsThread::start(config, model(), forward_camera());
    ASSERT_TRUE(points.ok());
    Image<std::uint8_t> left(model().width, model().height);
    Image<std::int16_t> disparity(model().width, model().height);
    left.fill(7);
    for (int i = 0; i < kFrames; ++i) {
      disparity.fill(static_cast<std::int16_t>(160 + i));
      (*points)->offer(kFirstStampNs + i * kPeriodNs, left.cview(), disparity.cview());
      EXPECT_TRUE((*points)->after_frame(*publisher));
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    }
  }
  lcm::LogFile log(path, "r");
  int read = 0;
  std::int64_t last = 0;
  for (const lcm::LogEvent* event = log.readNextEvent(); event != nullptr; event = log.readNextEvent(), ++read) {
    points_t m{};
    ASSERT_EQ(m.decode(event->data, 0, event->datalen), event->datalen);
    EXPECT_GT(m.utime, last);
    last = m.utime;
    const auto frame = (m.utime * 1000 - kFirstStampNs + kPeriodNs / 2) / kPeriodNs;
    const double depth_m = model().depth_m((160.0 + static_cast<double>(frame)) / 16.0);
    EXPECT_NEAR(m.x[0], 0.3 + depth_m, 1e-5) << "the disparity is that of the stamp";
  }
  EXPECT_EQ(read, copied);
  EXPECT_GT(read, 5);
  EXPECT_LT(read, kFrames / 2 + 1) << "given, made and handed over take a frame each at least";
}

}  // namespace
}  // namespace cliquevo::daemon
