// SPDX-License-Identifier: BSD-3-Clause
// Things that move by themselves, on rendered courses: where they are reported, something does move so.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "daemon/pipeline/frame_pipeline.h"
#include "drivers/simulator.h"
#include "drivers/simulator/course.h"
#include "drivers/simulator/world.h"

namespace cliquevo::test {
namespace {

struct Ride {
  int frames = 0;
  int valid = 0;
  int movers = 0;
  int on_a_thing = 0;             // of these, whose centre is on one that moves, or next to it
  std::vector<double> off_m_s;    // of these, by how much their velocity is off
  std::vector<double> speed_m_s;  // true one
};

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::nth_element(values.begin(), values.begin() + std::ssize(values) / 2, values.end());
  return values[values.size() / 2];
}

Ride ride(const std::string& text) {
  constexpr double kNextTo_m = 0.3;
  Ride out;
  const auto options = drivers::parse_simulator_options(text);
  EXPECT_TRUE(options.ok()) << text;
  const drivers::sim::Course course(*options);
  const drivers::sim::World world(*options, course);
  auto simulator = drivers::open_simulator(*options);
  EXPECT_TRUE(simulator.ok());
  auto pipeline = daemon::FramePipeline::make({}, (*simulator)->info());
  EXPECT_TRUE(pipeline.ok());
  drivers::StereoPair pair;
  for (int frame = 0;; ++frame) {
    const auto more = (*simulator)->next(pair);
    if (!more.ok() || !*more) break;
    EXPECT_TRUE(pipeline->process(pair).ok());
    ++out.frames;
    out.valid += pipeline->estimate().status == vo::Status::valid ? 1 : 0;
    const RigidTransform T_world_camera = course.T_world_camera(frame);
    const auto now = world.movers(frame);
    const auto before = world.movers(frame - 1);
    for (int m = 0; m < pipeline->movers().count; ++m) {
      const vo::Mover& mover = pipeline->movers().mover[static_cast<std::size_t>(m)];
      ++out.movers;
      const Eigen::Vector3d centre = T_world_camera * mover.centre;
      for (std::size_t k = 0; k < now.size(); ++k) {
        const Eigen::Vector3d own = now[k].R_world_local.transpose() * (centre - now[k].center);
        if ((own.cwiseAbs() - now[k].half_size).cwiseMax(0.0).norm() > kNextTo_m) continue;
        const Eigen::Vector3d was = before[k].R_world_local * own + before[k].center;
        const Eigen::Vector3d velocity = T_world_camera.R.transpose() * (centre - was) * options->rate_hz;
        ++out.on_a_thing;
        out.off_m_s.push_back((mover.velocity_m_s - velocity).norm());
        out.speed_m_s.push_back(velocity.norm());
        break;
      }
    }
  }
  fmt::print(
      "{}: {} of {} frames valid, {} movers reported, {} on a thing that moves, velocity off by {:.2f} of {:.2f} m/s "
      "(medians)\n",
      text, out.valid, out.frames, out.movers, out.on_a_thing, median(out.off_m_s), median(out.speed_m_s));
  return out;
}

TEST(MoversOnACourse, AreToldWhereTheyAreAndHowFast) {
  const Ride found = ride("course=wheeled,frames=150,movers=3");
  EXPECT_GE(found.valid, 140);
  EXPECT_GE(found.movers, 30);
  EXPECT_GE(found.on_a_thing, 0.9 * found.movers);
  EXPECT_LE(median(found.off_m_s), 0.2 * median(found.speed_m_s));
}

TEST(MoversOnACourse, AreNotToldWhereNothingMoves) { EXPECT_EQ(ride("course=wheeled,frames=150").movers, 0); }

}  // namespace
}  // namespace cliquevo::test
