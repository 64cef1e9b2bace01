// SPDX-License-Identifier: BSD-3-Clause
// Whether the covariance is right: errors of rendered courses, normalised by it. Expected for six degrees of
// freedom: 6.
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <Eigen/Cholesky>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "daemon/pipeline/frame_pipeline.h"
#include "drivers/simulator.h"

namespace cliquevo::test {
namespace {

constexpr double kDegrees = 180.0 / 3.14159265358979323846;

struct Normalised {
  double mean = 0.0;      // error squared
  double sigma_mm = 0.0;  // medians of a frame
  double sigma_deg = 0.0;
};

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + std::ssize(values) / 2, values.end());
  return values[values.size() / 2];
}

Normalised normalised(const std::string& text) {
  Normalised out;
  const auto options = drivers::parse_simulator_options(text);
  EXPECT_TRUE(options.ok()) << text;
  auto simulator = drivers::open_simulator(*options);
  EXPECT_TRUE(simulator.ok());
  auto pipeline = daemon::FramePipeline::make({}, (*simulator)->info());
  EXPECT_TRUE(pipeline.ok());
  std::map<TimestampNs, RigidTransform> truth;
  std::vector<double> mm, deg;
  drivers::StereoPair pair;
  for (;;) {
    const auto more = (*simulator)->next(pair);
    if (!more.ok() || !*more) break;
    truth[pair.stamp_ns] = *pair.truth_T_world_camera;
    EXPECT_TRUE(pipeline->process(pair).ok());
    const vo::Estimate& e = pipeline->estimate();
    if (e.status != vo::Status::valid) continue;
    const RigidTransform T_prev_cur = truth.at(e.prev_stamp_ns).inverse() * truth.at(e.stamp_ns);
    const Vector6d error = left_difference(e.T_prev_cur, T_prev_cur);
    out.mean += error.dot(e.covariance.ldlt().solve(error));
    mm.push_back(1e3 * std::sqrt(e.covariance.topLeftCorner<3, 3>().trace()));
    deg.push_back(kDegrees * std::sqrt(e.covariance.bottomRightCorner<3, 3>().trace()));
  }
  EXPECT_GT(mm.size(), 40U) << text;
  if (mm.empty()) return out;
  out.mean /= static_cast<double>(mm.size());
  out.sigma_mm = median(mm);
  out.sigma_deg = median(deg);
  fmt::print("{}: normalised error squared {:.2f}, sigma {:.2f} mm and {:.4f} degrees\n", text, out.mean, out.sigma_mm,
             out.sigma_deg);
  return out;
}

TEST(Covariance, HoldsOnTheSimulatorsCoursesAndStaysSmall) {
  for (const char* course : {"wheeled", "walking", "turn", "standing"}) {
    const Normalised n = normalised(fmt::format("course={},frames=160", course));
    EXPECT_GE(n.mean, 3.0) << course;
    EXPECT_LE(n.mean, 9.0) << course;
    EXPECT_LE(n.sigma_mm, 5.0) << course;
    EXPECT_LE(n.sigma_deg, 0.05) << course;
  }
}

TEST(Covariance, HoldsForSmallAndLargeImages) {
  for (const char* size : {"width=256,height=192,focal_px=280", "width=768,height=576,focal_px=840"}) {
    const Normalised n = normalised(fmt::format("course=wheeled,frames=50,{}", size));
    EXPECT_GE(n.mean, 3.0) << size;
    EXPECT_LE(n.mean, 7.0) << size;
  }
}

}  // namespace
}  // namespace cliquevo::test
