// SPDX-License-Identifier: BSD-3-Clause
#include "tools/simulated_recording.h"

#include <fstream>
#include <string>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "drivers/recording.h"
#include "drivers/simulator.h"
#include "tests/support/test_data.h"

namespace cliquevo::tools {
namespace {

class SimulatedRecordingTest : public testing::TestWithParam<const char*> {};

// What is written is what the simulator delivered, and the recording driver reads it back without any option.
TEST_P(SimulatedRecordingTest, ReadsBackAsTheSamePairsAndCalibration) {
  const auto options = drivers::parse_simulator_options(
      std::string("width=160,height=120,focal_px=175,frames=4,cache_dir=none,") + GetParam());
  ASSERT_TRUE(options.ok());
  auto simulator = drivers::open_simulator(*options);
  ASSERT_TRUE(simulator.ok());
  drivers::Simulator& source = **simulator;
  const std::string folder = test::scratch_dir();
  auto recording = SimulatedRecording::create(folder, source.info().calibration, source.info().rate_hz);
  ASSERT_TRUE(recording.ok()) << recording.error().line();
  std::vector<drivers::StereoPair> pairs(4);
  for (auto& pair : pairs) {
    ASSERT_TRUE(*source.next(pair));
    ASSERT_TRUE(recording->add(pair, source.truth_disparity()).ok());
  }
  const auto disparity = source.truth_disparity();
  ASSERT_TRUE(recording->finish().ok());

  drivers::RecordingOptions read;
  read.path = folder;
  auto opened = drivers::open_recording(read);
  ASSERT_TRUE(opened.ok()) << opened.error().line();
  const StereoCalibration& a = source.info().calibration;
  const StereoCalibration& b = (*opened)->info().calibration;
  EXPECT_EQ(a.rectified, b.rectified);
  EXPECT_LT((a.T_right_left.R - b.T_right_left.R).norm(), 1e-12);
  EXPECT_LT((a.T_right_left.t - b.T_right_left.t).norm(), 1e-12);
  EXPECT_NEAR(a.left.fx_px, b.left.fx_px, 1e-9);
  EXPECT_NEAR(a.right.cy_px, b.right.cy_px, 1e-9);
  for (std::size_t k = 0; k < 4; ++k) EXPECT_NEAR(a.right.coefficients[k], b.right.coefficients[k], 1e-12);
  drivers::StereoPair pair;
  for (const auto& want : pairs) {
    ASSERT_TRUE(*(*opened)->next(pair));
    EXPECT_EQ(pair.stamp_ns - want.stamp_ns, a.rectified ? -pairs[0].stamp_ns : 0);
    for (int y = 0; y < 120; ++y) {
      EXPECT_EQ(std::memcmp(pair.left.view().row(y), want.left.view().row(y), 160), 0) << y;
      EXPECT_EQ(std::memcmp(pair.right.view().row(y), want.right.view().row(y), 160), 0) << y;
    }
  }

  const cv::Mat file = cv::imread(folder + "/disp_0/000003.png", cv::IMREAD_UNCHANGED);
  ASSERT_EQ(file.type(), CV_16U);
  for (int y = 0; y < 120; ++y) {
    for (int x = 0; x < 160; ++x) {
      const float d = disparity(x, y);
      if (d == d) {
        EXPECT_NEAR(file.at<std::uint16_t>(y, x) / 256.0, static_cast<double>(d), 0.002);
      } else {
        EXPECT_EQ(file.at<std::uint16_t>(y, x), 0);
      }
    }
  }
  std::ifstream poses(folder + "/poses.txt");
  for (const auto& want : pairs) {
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 4; ++j) {
        double v = 0.0;
        poses >> v;
        const auto& T = *want.truth_T_world_camera;
        EXPECT_NEAR(v, j < 3 ? T.R(i, j) : T.t[i], 1e-9);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Pair, SimulatedRecordingTest, testing::Values("course=wheeled", "raw=on"),
                         [](const auto& i) { return i.index == 0 ? "rectified" : "raw"; });

TEST(SimulatedRecordingFolder, IsNotWrittenOver) {
  const std::string folder = test::scratch_dir();
  std::ofstream(folder + "/mine.txt") << "keep";
  const auto recording = SimulatedRecording::create(folder, StereoCalibration{}, 30.0);
  ASSERT_FALSE(recording.ok());
  EXPECT_EQ(recording.error().where, folder);
}

}  // namespace
}  // namespace cliquevo::tools
