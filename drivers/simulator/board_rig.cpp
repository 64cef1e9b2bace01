// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/board_rig.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "drivers/simulator/hash.h"
#include "drivers/simulator/raw_pair.h"
#include "stereo/rectification.h"

namespace cliquevo::drivers::sim {

namespace {

constexpr double kBorder_px = 2.0;    // what is nearer to the image's edge is not counted as seen
constexpr double kMostAngle = 1.75;   // rad from the axis: fisheyes of 200 degrees
constexpr double kWideFocal = 0.7;    // of the diagonal: shorter ones have a wide view,
constexpr double kWideLens = 0.25;    // and lenses that bend less
constexpr double kMostTurn = 0.01;    // rad, about each axis, of each camera
constexpr double kMostShift = 0.015;  // of the centre, of the width

struct LensRow {
  const char* name;
  Distortion distortion;
  std::array<double, 8> coefficients;  // of rig_seed 0
};

constexpr std::array<LensRow, 4> kLenses{
    {{"none", Distortion::none, {}},
     {"plumb_bob", Distortion::plumb_bob, {-0.281, 0.083, 0.0004, -0.0002}},
     {"rational", Distortion::rational, {0.12, -0.03, 0.0004, -0.0003, 0.002, 0.41, 0.03, 0.004}},
     {"equidistant", Distortion::equidistant, {-0.012, 0.003, -0.0015, 0.0002}}}};

const LensRow& row_of(const SimulatorOptions& o) {
  const std::string name = !o.lens.empty() ? o.lens : o.raw ? "plumb_bob" : "none";
  return *std::find_if(kLenses.begin(), kLenses.end(), [&](const LensRow& row) { return name == row.name; });
}

CameraCalibration lens(const SimulatorOptions& o, const LensRow& row, Random& random) {
  CameraCalibration c;
  c.width = o.width;
  c.height = o.height;
  c.fx_px = o.focal_px * random.uniform(0.985, 1.015);
  c.fy_px = c.fx_px * random.uniform(0.997, 1.003);
  c.cx_px = 0.5 * (o.width - 1) + random.uniform(-kMostShift, kMostShift) * o.width;
  c.cy_px = 0.5 * (o.height - 1) + random.uniform(-kMostShift, kMostShift) * o.width;
  c.distortion = row.distortion;
  const bool wide = o.focal_px < kWideFocal * std::hypot(o.width, o.height);
  const double strength = wide && row.distortion == Distortion::plumb_bob ? kWideLens : 1.0;
  for (std::size_t i = 0; i < row.coefficients.size(); ++i) {
    c.coefficients[i] = row.coefficients[i] * strength * random.uniform(0.7, 1.0);
  }
  return c;
}

StereoCalibration random_rig(const SimulatorOptions& o) {
  const LensRow& row = row_of(o);
  Random random(mix64(o.rig_seed ^ 0x626f617264ULL));
  StereoCalibration c;
  c.source = "simulator";
  c.left = lens(o, row, random);
  c.right = lens(o, row, random);
  Eigen::Vector3d turn, along;
  for (int i = 0; i < 3; ++i) turn(i) = 2.0 * random.uniform(-kMostTurn, kMostTurn);
  along << -1.0, random.uniform(-kMostTurn, kMostTurn), random.uniform(-kMostTurn, kMostTurn);
  c.T_right_left.R = so3_exp(turn);
  c.T_right_left.t = c.T_right_left.R * (o.baseline_m * along.normalized());
  return c;
}

// The mount of the courses' raw pair, with other lenses.
StereoCalibration fixed_rig(const SimulatorOptions& o) {
  const LensRow& row = row_of(o);
  SimulatorOptions as_course = o;
  as_course.raw = row.distortion != Distortion::none;
  StereoCalibration c = simulated_calibration(as_course);
  if (row.distortion == Distortion::none || row.distortion == Distortion::plumb_bob) return c;
  for (CameraCalibration* camera : {&c.left, &c.right}) {
    camera->distortion = row.distortion;
    camera->coefficients = row.coefficients;
  }
  c.prescribed.reset();
  return c;
}

}  // namespace

bool is_lens_name(const std::string& name) {
  return std::any_of(kLenses.begin(), kLenses.end(), [&](const LensRow& row) { return name == row.name; });
}

StereoCalibration board_rig(const SimulatorOptions& o) {
  StereoCalibration c = o.rig_seed == 0 ? fixed_rig(o) : random_rig(o);
  if (!c.prescribed) {
    if (const auto chosen = stereo::choose_rectification(c)) c.prescribed = *chosen;
  }
  return c;
}

std::optional<Eigen::Vector2d> SimulatedLens::project(const Eigen::Vector3d& point) const {
  if (!is_fisheye()) return pinhole_.project(point);
  const double across = point.head<2>().norm();
  const double angle = std::atan2(across, point.z());
  if (angle > kMostAngle) return std::nullopt;
  const auto& k = camera_.coefficients;
  const double a2 = angle * angle;
  const double bent = angle * (1.0 + a2 * (k[0] + a2 * (k[1] + a2 * (k[2] + a2 * k[3]))));
  const Eigen::Vector2d to =
      across > 0.0 ? Eigen::Vector2d(point.head<2>() * (bent / across)) : Eigen::Vector2d::Zero();
  return Eigen::Vector2d(camera_.fx_px * to.x() + camera_.cx_px, camera_.fy_px * to.y() + camera_.cy_px);
}

std::optional<Eigen::Vector3d> SimulatedLens::direction(double u, double v) const {
  if (!is_fisheye()) {
    const auto at = pinhole_.direction(u, v);
    if (!at) return std::nullopt;
    return at->normalized();
  }
  const double x = (u - camera_.cx_px) / camera_.fx_px, y = (v - camera_.cy_px) / camera_.fy_px;
  const double bent = std::hypot(x, y);
  const auto& k = camera_.coefficients;
  double angle = bent;
  for (int i = 0; i < 20; ++i) {
    const double a2 = angle * angle;
    const double error = angle * (1.0 + a2 * (k[0] + a2 * (k[1] + a2 * (k[2] + a2 * k[3])))) - bent;
    const double slope = 1.0 + a2 * (3.0 * k[0] + a2 * (5.0 * k[1] + a2 * (7.0 * k[2] + a2 * 9.0 * k[3])));
    if (!(slope > 0.05)) return std::nullopt;
    angle -= error / slope;
    if (std::abs(error) < 1e-14) break;
  }
  if (!(angle <= kMostAngle)) return std::nullopt;
  const double along = bent > 0.0 ? std::sin(angle) / bent : 1.0;
  return Eigen::Vector3d(x * along, y * along, std::cos(angle));
}

bool SimulatedLens::shows(const Eigen::Vector3d& point) const {
  const auto px = project(point);
  return px && px->x() >= kBorder_px && px->y() >= kBorder_px && px->x() <= camera_.width - 1 - kBorder_px &&
         px->y() <= camera_.height - 1 - kBorder_px;
}

}  // namespace cliquevo::drivers::sim
