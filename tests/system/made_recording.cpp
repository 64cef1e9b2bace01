// SPDX-License-Identifier: BSD-3-Clause
#include "tests/system/made_recording.h"

#include <filesystem>
#include <fstream>
#include <map>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>

#include "daemon/pipeline/trajectory_file.h"
#include "drivers/simulator.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {

namespace fs = std::filesystem;

namespace {

void write_image(const std::string& path, Image<std::uint8_t>& image) {
  const auto view = image.view();
  cv::imwrite(path, cv::Mat(view.height, view.width, CV_8UC1, view.data, static_cast<std::size_t>(view.stride)));
}

std::string make(int pairs) {
  drivers::SimulatorOptions options;
  options.width = 320;
  options.height = 240;
  options.focal_px = 350.0;
  options.frames = pairs;
  options.cache_dir = "none";
  auto simulator = drivers::open_simulator(options);
  EXPECT_TRUE(simulator.ok());
  const std::string folder = scratch_dir();
  fs::create_directories(folder + "/image_0");
  fs::create_directories(folder + "/image_1");
  std::ofstream times(folder + "/times.txt");
  std::ofstream poses(folder + "/poses.txt");
  drivers::StereoPair pair;
  for (int i = 0; i < pairs && (*simulator)->next(pair).ok(); ++i) {
    write_image(image_of(folder, 0, i), pair.left);
    write_image(image_of(folder, 1, i), pair.right);
    times << fmt::format("{}.{:09}\n", pair.stamp_ns / 1'000'000'000, pair.stamp_ns % 1'000'000'000);
    poses << daemon::format_pose(daemon::TrajectoryFormat::kitti, 0, *pair.truth_T_world_camera) << '\n';
  }
  const StereoModel& m = (*simulator)->info().calibration.prescribed->model;
  std::ofstream(folder + "/calib.txt") << fmt::format(
      "P0: {0} 0 {1} 0 0 {0} {2} 0 0 0 1 0\nP1: {0} 0 {1} {3} 0 {0} {2} 0 0 0 1 0\n", m.fx_px, m.cx_px, m.cy_px,
      -m.fx_px * m.baseline_m);
  return folder;
}

}  // namespace

std::string made_recording(int pairs) {
  static std::map<int, std::string> made;
  if (!made.contains(pairs)) made[pairs] = make(pairs);
  const std::string copy = scratch_dir();
  fs::copy(made[pairs], copy, fs::copy_options::recursive);
  return copy;
}

std::string image_of(const std::string& recording, int side, int pair) {
  return fmt::format("{}/image_{}/{:06}.png", recording, side, pair);
}

void blank_pair(const std::string& recording, int pair) {
  for (const int side : {0, 1}) {
    const std::string path = image_of(recording, side, pair);
    cv::Mat image = cv::imread(path, cv::IMREAD_GRAYSCALE);
    image.setTo(128);
    cv::imwrite(path, image);
  }
}

void tear(const std::string& path) { fs::resize_file(path, fs::file_size(path) / 2); }

}  // namespace cliquevo::test
