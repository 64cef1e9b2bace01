// SPDX-License-Identifier: BSD-3-Clause
// What is done to finished images, when and to which camera.
#include "drivers/simulator/fault.h"

#include <cmath>
#include <set>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/simulator/camera_sets.h"
#include "drivers/simulator/course.h"
#include "drivers/simulator/hash.h"
#include "drivers/simulator/raster.h"
#include "drivers/simulator/raw_pair.h"
#include "drivers/simulator/sensor.h"

namespace cliquevo::drivers::sim {
namespace {

SimulatorOptions with_fault(const std::string& fault) {
  SimulatorOptions o;
  o.fault = fault;
  o.fault_first = 10;
  o.fault_frames = 3;
  return o;
}

Image<std::uint8_t> picture() {
  Image<std::uint8_t> image(64, 48);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) image.view()(x, y) = static_cast<std::uint8_t>(60 + x + y);
  }
  return image;
}

Image<std::uint8_t> after(const std::string& fault, std::int64_t frame, int side) {
  Image<std::uint8_t> image = picture();
  apply_fault(with_fault(fault), frame, side, image);
  return image;
}

double mean(const Image<std::uint8_t>& image) {
  double sum = 0.0;
  for (int y = 0; y < image.height(); ++y) {
    for (int x = 0; x < image.width(); ++x) sum += image.view()(x, y);
  }
  return sum / (image.width() * image.height());
}

bool same(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b) {
  for (int y = 0; y < a.height(); ++y) {
    for (int x = 0; x < a.width(); ++x) {
      if (a.view()(x, y) != b.view()(x, y)) return false;
    }
  }
  return true;
}

TEST(Fault, IsOnFromItsFirstFrameForSoMany) {
  SimulatorOptions o = with_fault("blank");
  for (const std::int64_t frame : {9, 13, 100}) EXPECT_FALSE(fault_active(o, frame)) << frame;
  for (const std::int64_t frame : {10, 11, 12}) EXPECT_TRUE(fault_active(o, frame)) << frame;
  o.fault_frames = -1;
  EXPECT_TRUE(fault_active(o, 100)) << "to the end";
  o.fault = "none";
  EXPECT_FALSE(fault_active(o, 100));
}

TEST(Fault, LeavesThePicturesBeforeAndAfterAlone) {
  for (const char* fault : {"blank", "noise", "covered", "flare"}) {
    EXPECT_TRUE(same(after(fault, 9, 0), picture())) << fault;
    EXPECT_TRUE(same(after(fault, 13, 1), picture())) << fault;
    EXPECT_FALSE(same(after(fault, 11, 0), picture())) << fault;
  }
}

TEST(Fault, DoesWhatItsNameSays) {
  EXPECT_EQ(mean(after("blank", 11, 1)), 128.0);
  EXPECT_NEAR(mean(after("noise", 11, 0)), 127.5, 5.0);
  EXPECT_FALSE(same(after("noise", 11, 0), after("noise", 11, 1))) << "each camera has its own";
  EXPECT_TRUE(same(after("noise", 11, 0), after("noise", 11, 0))) << "and it repeats";
  EXPECT_LT(mean(after("covered", 11, 0)), 0.4 * mean(picture()));
  EXPECT_TRUE(same(after("covered", 11, 1), picture())) << "the left camera alone";
  EXPECT_GT(mean(after("flare", 11, 1)), mean(picture()) + 20.0);
  EXPECT_LT(fault_gain(with_fault("night"), 11), 0.1);
  EXPECT_EQ(fault_gain(with_fault("night"), 9), 1.0);
}

TEST(Fault, AFrozenRightCameraKeepsItsLastGoodImage) {
  const SimulatorOptions o = with_fault("frozen");
  EXPECT_EQ(delivered_frame(o, 9, 1), 9);
  EXPECT_EQ(delivered_frame(o, 11, 1), 9);
  EXPECT_EQ(delivered_frame(o, 11, 0), 11) << "the left one goes on";
  EXPECT_EQ(delivered_frame(o, 13, 1), 13);
}

TEST(CameraSets, FillWhatWasLeftOpenAndNoMore) {
  SimulatorOptions o;
  o.camera = "webcam";
  o.defocus_px = 0.1;
  const SimulatorOptions filled = with_camera(o);
  EXPECT_EQ(filled.jpeg_quality, 70);
  EXPECT_EQ(filled.defocus_px, 0.1);
  take_camera_size(o);
  EXPECT_EQ(o.width, 320);
  EXPECT_EQ(o.focal_px, 350.0);
  EXPECT_TRUE(is_camera_set("action"));
  EXPECT_FALSE(is_camera_set("telescope"));
  EXPECT_NE(camera_set_names().find("flexing"), std::string::npos);
}

TEST(Course, DrivesItsStepAFrameAndTurnsOnTheSpotWhereItIsATurn) {
  SimulatorOptions o;
  for (const char* name : {"wheeled", "walking", "straight"}) {
    o.course = name;
    const Course course(o);
    EXPECT_TRUE(course.moves());
    EXPECT_NEAR(course.length_m(), o.step_m * static_cast<double>(o.frames), 1e-9);
    double way_m = 0.0;
    for (int i = 0; i < 100; ++i) {
      way_m += (course.position(o.step_m * (i + 1)) - course.position(o.step_m * i)).norm();
    }
    EXPECT_NEAR(way_m, 100 * o.step_m, 0.01) << name;
  }
  o.course = "turn";
  const Course turn(o);
  EXPECT_NEAR((turn.T_world_camera(50.0).t - turn.T_world_camera(0.0).t).norm(), 0.0, 1e-9);
  EXPECT_GT((turn.T_world_camera(0.0).inverse() * turn.T_world_camera(20.0)).angle(), 0.05);
  o.course = "standing";
  EXPECT_TRUE(Course(o).still());
}

TEST(Course, IsClosedAndTheGroundIsSmooth) {
  const Course course(SimulatorOptions{});
  EXPECT_NEAR((course.position(course.lap_m() + 12.3) - course.position(12.3)).norm(), 0.0, 1e-6);
  const Terrain& ground = course.terrain();
  for (double x = -20.0; x < 20.0; x += 0.37) {
    EXPECT_LT(std::abs(ground.height(x + 0.01, 3.0) - ground.height(x, 3.0)), 0.01) << "no steps";
  }
  EXPECT_NE(Terrain(1).height(5.0, 5.0), Terrain(2).height(5.0, 5.0));
}

TEST(RawCamera, BringsAPinholePictureThroughTheLensWithoutMovingIt) {
  SimulatorOptions o;
  o.width = 96, o.height = 72, o.focal_px = 100.0;
  EXPECT_FALSE(simulated_calibration(o).rectified == o.raw);
  EXPECT_EQ(rectified_model(o).cx_px, 47.5);
  o.raw = true;
  const StereoCalibration c = simulated_calibration(o);
  EXPECT_TRUE(c.prescribed.has_value());
  const RawCamera camera(c.left);
  // A slope along the rows, in the directions of the pinhole's pixels: each raw pixel shows the direction that it sees.
  std::vector<float> pinhole(static_cast<std::size_t>(camera.width()) * static_cast<std::size_t>(camera.height()));
  for (int y = 0; y < camera.height(); ++y) {
    for (int x = 0; x < camera.width(); ++x) {
      pinhole[static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width()) + static_cast<std::size_t>(x)] =
          static_cast<float>((x - camera.cx_px()) / camera.focal_px()) + 1.0F;
    }
  }
  Image<std::uint16_t> raw;
  camera.resample(pinhole, 1000.0F, 4000.0F, raw);
  ASSERT_EQ(raw.width(), 96);
  const auto shown = [&](int u, int v) { return raw.view()(u, v) / 1000.0 - 1.0; };
  const int u = static_cast<int>(std::lround(c.left.cx_px)), v = static_cast<int>(std::lround(c.left.cy_px));
  EXPECT_NEAR(shown(u, v), (u - c.left.cx_px) / c.left.fx_px, 0.002) << "in the middle the lens does nothing";
  // Barrel distortion: the border sees further out than a pinhole's would.
  EXPECT_GT(shown(94, v), (94 - c.left.cx_px) / c.left.fx_px + 0.005);
  EXPECT_LT(shown(1, v), (1 - c.left.cx_px) / c.left.fx_px - 0.005);
}

TEST(Plane, CanBeReadBeyondItsBorders) {
  Plane plane;
  plane.resize(20, 10);
  plane.fill(3.0F);
  EXPECT_EQ(plane.row(0)[0], 3.0F);
  EXPECT_EQ(plane.row(9)[19], 3.0F);
  const Plane& seen = plane;
  EXPECT_EQ(seen.row(-1)[5], 0.0F) << "a row above";
  EXPECT_EQ(seen.row(10)[5], 0.0F) << "and one below";
}

TEST(Random, IsUniformAndNeverRepeatsWhatAnotherSeedGave) {
  Random random(7);
  double sum = 0.0;
  std::set<std::uint64_t> seen;
  for (int i = 0; i < 10000; ++i) {
    const double u = random.uniform(-1.0, 3.0);
    ASSERT_GE(u, -1.0);
    ASSERT_LT(u, 3.0);
    sum += u;
    seen.insert(hash_cell(7, i, -i));
  }
  EXPECT_NEAR(sum / 10000, 1.0, 0.05);
  EXPECT_EQ(seen.size(), 10000U);
  EXPECT_NE(hash_cell(7, 1, 2), hash_cell(7, 2, 1));
}

TEST(Exposure, DriftsAndStepsWithinAFifthAndOnlyWhereItIsOn) {
  SimulatorOptions o;
  double least = 1.0, most = 1.0;
  for (std::int64_t frame = 0; frame < 1000; ++frame) {
    least = std::min(least, exposure_gain(o, frame));
    most = std::max(most, exposure_gain(o, frame));
  }
  EXPECT_GT(least, 0.75);
  EXPECT_LT(least, 0.95);
  EXPECT_LT(most, 1.25);
  EXPECT_GT(most, 1.05);
  o.exposure_changes = false;
  EXPECT_EQ(exposure_gain(o, 123), 1.0);
}

}  // namespace
}  // namespace cliquevo::drivers::sim
