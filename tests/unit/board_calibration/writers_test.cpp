// SPDX-License-Identifier: BSD-3-Clause
// Every format that is written is read back by our own reader as the same calibration.
#include "drivers/calibration/writers.h"

#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include "drivers/calibration_file.h"
#include "stereo/rectification.h"
#include "tests/support/test_data.h"
#include "tests/unit/board_calibration/made_rig.h"

namespace cliquevo::drivers {
namespace {

std::string write(const CalibrationWriter& writer, const StereoCalibration& calibration, const std::string& folder) {
  const auto files = writer.write(calibration, folder + "/rig.yaml");
  EXPECT_TRUE(files.ok()) << writer.name << ": " << files.error().line();
  if (!files.ok()) return "";
  for (const CalibrationFile& file : *files) {
    std::ofstream(file.path) << file.text;
  }
  return files->front().path;
}

void expect_same(const CameraCalibration& a, const CameraCalibration& b, const std::string& where) {
  EXPECT_EQ(a.fx_px, b.fx_px) << where;
  EXPECT_EQ(a.fy_px, b.fy_px) << where;
  EXPECT_EQ(a.cx_px, b.cx_px) << where;
  EXPECT_EQ(a.cy_px, b.cy_px) << where;
  EXPECT_EQ(a.distortion, b.distortion) << where;
  EXPECT_EQ(a.coefficients, b.coefficients) << where;
}

TEST(CalibrationWriters, WhatTheyWriteIsReadBackIdentically) {
  for (const std::uint64_t seed : {0, 2, 3}) {  // radtan, plumb-bob, fisheye
    const auto made = calibration::make_rig(seed, 5, 0.0);
    const StereoCalibration original = made.rig.calibration();
    for (const CalibrationWriter& writer : calibration_writers()) {
      const std::string name = writer.name;
      if (name == "kitti") continue;
      const std::string folder = test::scratch_dir() + "/" + name + std::to_string(seed);
      std::filesystem::create_directories(folder);
      const std::string path = write(writer, original, folder);
      const auto read = read_calibration(path, original.left.width, original.left.height);
      ASSERT_TRUE(read.ok()) << read.error().line();
      expect_same(read->left, original.left, name);
      expect_same(read->right, original.right, name);
      if (name == "ros") continue;  // the pose is in its projection matrices: to rounding
      EXPECT_LT((read->T_right_left.R - original.T_right_left.R).norm(), 1e-12) << name;
      EXPECT_LT((read->T_right_left.t - original.T_right_left.t).norm(), 1e-12) << name;
    }
  }
}

TEST(CalibrationWriters, KittiIsTheRectifiedPair) {
  const auto made = calibration::make_rig(0, 5, 0.0);
  const StereoCalibration original = made.rig.calibration();
  const std::string folder = test::scratch_dir();
  const auto files = find_calibration_writer("kitti")->write(original, folder + "/calib.txt");
  ASSERT_TRUE(files.ok());
  std::ofstream(files->front().path) << files->front().text;
  const auto read = read_calibration(folder + "/calib.txt", original.left.width, original.left.height);
  ASSERT_TRUE(read.ok()) << read.error().line();
  const auto rectification = stereo::choose_rectification(original);
  ASSERT_TRUE(rectification.ok() && read->prescribed);
  EXPECT_EQ(read->prescribed->model.fx_px, rectification->model.fx_px);
  EXPECT_NEAR(read->prescribed->model.baseline_m, rectification->model.baseline_m, 1e-12);
}

TEST(CalibrationWriters, ALensThatAFormatCannotHoldIsRefused) {
  auto made = calibration::make_rig(2, 5, 0.0);
  made.rig.model = calibration::find_lens_model("rational");
  made.rig.left(11) = made.rig.right(11) = 0.01;
  const auto files = find_calibration_writer("kalibr")->write(made.rig.calibration(), "/x/rig.yaml");
  ASSERT_FALSE(files.ok());
  EXPECT_NE(files.error().line().find("kalibr"), std::string::npos);
}

}  // namespace
}  // namespace cliquevo::drivers
