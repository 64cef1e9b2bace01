// SPDX-License-Identifier: BSD-3-Clause
// VO_POINTS against the simulator's exact disparity: whether points lie where things are, and as near as their sigma
// says.
#include "daemon/lcm/points.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>

#include "daemon/pipeline/config.h"
#include "daemon/pipeline/frame_pipeline.h"
#include "drivers/simulator.h"
#include "stereo/dense_stereo.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {
namespace {

struct Errors {
  std::vector<double> normalised;  // along the ray, by sigma
  std::size_t without_truth = 0;
};

// Errors of every tenth frame's points, by the range of the truth.
Errors errors_of(const std::string& course, double from_m, double to_m) {
  Errors out;
  const auto options = drivers::parse_simulator_options(course);
  EXPECT_TRUE(options.ok());
  auto simulator = drivers::open_simulator(*options);
  EXPECT_TRUE(simulator.ok());
  auto pipeline = daemon::FramePipeline::make({}, (*simulator)->info());
  EXPECT_TRUE(pipeline.ok());
  const StereoModel& model = pipeline->model();
  daemon::Mounting mounting;
  mounting.translation_m = {0.4, -0.1, 0.85};
  mounting.roll_pitch_yaw_deg = {1.0, 13.0, -2.0};
  const RigidTransform T_body_camera = mounting.T_body_camera();
  daemon::ImageTap tap({.width = model.width, .height = model.height, .rate_hz = 3.0});
  drivers::StereoPair pair;
  points_t points{};
  for (;;) {
    const auto more = (*simulator)->next(pair);
    if (!more.ok() || !*more) break;
    EXPECT_TRUE(pipeline->process(pair).ok());
    tap.offer(pair.stamp_ns, pipeline->rectified_left(), {}, pipeline->disparity());
    if (tap.take() == nullptr) continue;
    daemon::build_points(*tap.take(), model, T_body_camera, 4, points);
    tap.give_back();
    for (std::size_t i = 0; i < points.x.size(); ++i) {
      const Eigen::Vector3d p = T_body_camera.inverse() * Eigen::Vector3d(points.x[i], points.y[i], points.z[i]);
      const Eigen::Vector3d pixel = model.project(p);
      const float truth_px =
          (*simulator)
              ->truth_disparity()(static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y())));
      if (!std::isfinite(truth_px)) {
        ++out.without_truth;
        continue;
      }
      const double range_m = model.triangulate(pixel.x(), pixel.y(), truth_px).norm();
      if (range_m < from_m || range_m >= to_m) continue;
      const double sigma_at_truth = points.sigma[i] * std::pow(range_m / p.norm(), 2);
      out.normalised.push_back((p.norm() - range_m) / sigma_at_truth);
    }
  }
  return out;
}

double share_within(const Errors& errors, double sigmas) {
  const auto within = std::count_if(errors.normalised.begin(), errors.normalised.end(),
                                    [=](double e) { return std::abs(e) <= sigmas; });
  return static_cast<double>(within) / static_cast<double>(errors.normalised.size());
}

void print(const std::string& name, const Errors& errors) {
  fmt::print("{}: {:.1f} % within one sigma, {:.1f} % within three, of {} points\n", name,
             100 * share_within(errors, 1.0), 100 * share_within(errors, 3.0), errors.normalised.size());
}

// Texture and light are better there than outdoors: sigma is that of real pictures, and on the safe side here.
TEST(Points, LieWhereThingsAreAtEveryRangeOfTheSimulator) {
  for (const auto& [from_m, to_m] : {std::pair{0.5, 3.0}, {3.0, 6.0}, {6.0, 20.0}}) {
    const Errors errors = errors_of("course=wheeled,frames=60", from_m, to_m);
    ASSERT_GT(errors.normalised.size(), 500U) << from_m;
    print(fmt::format("simulator, {} to {} m", from_m, to_m), errors);
    EXPECT_GT(share_within(errors, 1.0), 0.68);
    EXPECT_GT(share_within(errors, 3.0), 0.97);
  }
}

// Points of a pair whose disparities were measured by others, against those; of a camera made up, as sigma counts in
// px.
void add_errors(const std::string& left_file, const std::string& right_file, const std::string& truth_file,
                int disparities, Errors& out) {
  const cv::Mat left = cv::imread(left_file, cv::IMREAD_GRAYSCALE);
  const cv::Mat right = cv::imread(right_file, cv::IMREAD_GRAYSCALE);
  const cv::Mat truth = cv::imread(truth_file, cv::IMREAD_UNCHANGED);  // px * 256, 0 = unknown
  ASSERT_FALSE(left.empty() || right.empty() || truth.empty()) << left_file;
  StereoModel model{left.cols, left.rows, 700.0, 700.0, left.cols / 2.0, left.rows / 2.0, 0.5, 0.0};
  stereo::StereoParams params;
  params.num_disparities = disparities;
  auto dense = stereo::DenseStereo::make(params, model.width, model.height);
  ASSERT_TRUE(dense.ok());
  Image<std::uint8_t> filtered(model.width, model.height);
  Image<std::int16_t> disparity(model.width, model.height);
  const auto view = [](const cv::Mat& m) {
    return ImageView<const std::uint8_t>{m.data, m.cols, m.rows, static_cast<std::ptrdiff_t>(m.step)};
  };
  ASSERT_TRUE(dense->compute(view(left), view(right), filtered.view(), disparity.view()).ok());
  daemon::ImageTap tap({.width = model.width, .height = model.height, .rate_hz = 1.0});
  tap.offer(0, view(left), {}, disparity.cview());
  points_t points{};
  daemon::build_points(*tap.take(), model, RigidTransform{}, 4, points);
  for (std::size_t i = 0; i < points.x.size(); ++i) {
    const Eigen::Vector3d p(points.x[i], points.y[i], points.z[i]);
    const Eigen::Vector3d pixel = model.project(p);
    const auto known =
        truth.at<std::uint16_t>(static_cast<int>(std::lround(pixel.y())), static_cast<int>(std::lround(pixel.x())));
    if (known == 0) continue;
    const double range_m = model.triangulate(pixel.x(), pixel.y(), known / 256.0).norm();
    out.normalised.push_back((p.norm() - range_m) / (points.sigma[i] * std::pow(range_m / p.norm(), 2)));
  }
}

TEST(Points, LieWithinTheirSigmaOnRoadsAndIndoors) {
  CLIQUEVO_NEEDS_DATA("kitti_stereo_2012");
  CLIQUEVO_NEEDS_DATA("middlebury_motorcycle");
  namespace fs = std::filesystem;
  const fs::path kitti = data_dir() + "/kitti_stereo_2012";
  Errors roads;
  for (const auto& entry : fs::directory_iterator(kitti / "disp_noc")) {
    const std::string name = entry.path().filename().string();
    add_errors((kitti / "image_0" / name).string(), (kitti / "image_1" / name).string(), entry.path().string(), 128,
               roads);
  }
  const std::string motorcycle = data_dir() + "/middlebury_motorcycle/";
  Errors indoors;
  add_errors(motorcycle + "left.png", motorcycle + "right.png", motorcycle + "disparity.png", 64, indoors);
  for (const auto& [name, errors] : {std::pair{"roads", &roads}, {"indoors", &indoors}}) {
    ASSERT_GT(errors->normalised.size(), 3000U) << name;
    print(name, *errors);
    EXPECT_GT(share_within(*errors, 1.0), 0.6) << name;
    EXPECT_LT(share_within(*errors, 1.0), 0.9) << name << ": a sigma that is never reached says nothing";
    EXPECT_GT(share_within(*errors, 3.0), 0.9) << name;
  }
}

}  // namespace
}  // namespace cliquevo::test
