// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/course.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "drivers/simulator/hash.h"

namespace cliquevo::drivers::sim {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kNodeStepM = 0.25;
// The closed course has three-fold symmetry (its harmonics are multiples of three), which is what closes it exactly:
// heading(s + L/3) = heading(s) + 120 degrees, so the three thirds of the way add up to zero. Anything up to a lap is
// no loop, and an endless run needs no endless world.
constexpr double kLapM = 600.0;
// The vehicle: four wheels, the camera above the front axle.
constexpr double kWheelBaseM = 0.9;
constexpr double kTrackM = 0.7;
constexpr double kCameraForwardM = 0.35;

Eigen::Matrix3d rotation_zyx(double yaw, double pitch, double roll) {
  return (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(pitch, Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(roll, Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

}  // namespace

Course::Course(const SimulatorOptions& o)
    : terrain_(o.world_seed),
      step_m_(o.step_m),
      rate_hz_(o.rate_hz),
      camera_height_m_(o.camera_height_m),
      pitch_rad_(o.pitch_deg * kPi / 180.0),
      baseline_m_(o.baseline_m) {
  if (o.course == "walking") kind_ = Kind::walking;
  if (o.course == "standing") kind_ = Kind::standing;
  if (o.course == "straight") kind_ = Kind::straight;
  if (o.course == "turn") kind_ = Kind::turn;
  Random random(mix64(o.world_seed ^ 0xc0f5eULL));
  for (double& p : phase_) p = random.uniform(0.0, 2.0 * kPi);
  sway_rad_ = std::max(o.sway_deg, 0.0) * kPi / 180.0;
  Random swaying(mix64(o.world_seed ^ 0x73776179ULL));
  for (auto& axis : sway_phase_)
    for (double& p : axis) p = swaying.uniform(0.0, 2.0 * kPi);
  length_m_ = moves() ? step_m_ * static_cast<double>(o.frames) : 0.0;
  lap_m_ = std::numeric_limits<double>::infinity();
  if (kind_ == Kind::straight) return;
  lap_m_ = kLapM;
  const int nodes = static_cast<int>(kLapM / kNodeStepM);
  nodes_.resize(static_cast<std::size_t>(nodes) + 1, Eigen::Vector2d::Zero());
  for (int i = 0; i < nodes; ++i) {
    const double a = kNodeStepM * i;
    // Simpson's rule; the heading is so smooth that the error is below a nanometre a node.
    Eigen::Vector2d sum = Eigen::Vector2d::Zero();
    const double weights[3] = {1.0, 4.0, 1.0};
    for (int k = 0; k < 3; ++k) {
      const double psi = heading(a + 0.5 * kNodeStepM * k);
      sum += weights[k] * Eigen::Vector2d(std::cos(psi), std::sin(psi));
    }
    nodes_[static_cast<std::size_t>(i) + 1] = nodes_[static_cast<std::size_t>(i)] + sum * (kNodeStepM / 6.0);
  }
}

double Course::heading(double s) const {
  if (kind_ == Kind::straight) return 0.4;
  const double w = 2.0 * kPi * s / kLapM;
  return w + 0.75 * std::sin(9.0 * w + phase_[0]) + 0.30 * std::sin(24.0 * w + phase_[1]) +
         0.12 * std::sin(51.0 * w + phase_[2]);
}

Eigen::Vector2d Course::position(double s) const {
  if (kind_ == Kind::straight) return s * Eigen::Vector2d(std::cos(heading(0.0)), std::sin(heading(0.0)));
  s -= kLapM * std::floor(s / kLapM);
  const auto node = std::min(static_cast<std::size_t>(s / kNodeStepM), nodes_.size() - 2);
  const double a = kNodeStepM * static_cast<double>(node);
  const double h = s - a;
  // Two-point Gauss-Legendre would do; three points keep the position as smooth as the heading.
  const double offsets[3] = {0.5 - 0.5 * std::sqrt(0.6), 0.5, 0.5 + 0.5 * std::sqrt(0.6)};
  const double weights[3] = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
  Eigen::Vector2d p = nodes_[node];
  for (int k = 0; k < 3; ++k) {
    const double psi = heading(a + h * offsets[k]);
    p += h * weights[k] * Eigen::Vector2d(std::cos(psi), std::sin(psi));
  }
  return p;
}

RigidTransform Course::T_world_body(double s, double extra_yaw) const {
  const Eigen::Vector2d p = position(s);
  const double psi = heading(s) + extra_yaw;
  const Eigen::Vector2d forward(std::cos(psi), std::sin(psi));
  const Eigen::Vector2d left(-forward.y(), forward.x());
  double wheel[2][2];
  for (int i = 0; i < 2; ++i) {
    for (int j = 0; j < 2; ++j) {
      const Eigen::Vector2d w = p + (i - 0.5) * kWheelBaseM * forward + (j - 0.5) * kTrackM * left;
      wheel[i][j] = terrain_.height(w.x(), w.y());
    }
  }
  const double rise = 0.5 * (wheel[1][0] + wheel[1][1] - wheel[0][0] - wheel[0][1]) / kWheelBaseM;
  const double bank = 0.5 * (wheel[0][1] + wheel[1][1] - wheel[0][0] - wheel[1][0]) / kTrackM;
  RigidTransform T;
  const Eigen::Vector3d x = Eigen::Vector3d(forward.x(), forward.y(), rise).normalized();
  const Eigen::Vector3d z = x.cross(Eigen::Vector3d(left.x(), left.y(), bank)).normalized();
  T.R.col(0) = x;
  T.R.col(1) = z.cross(x);
  T.R.col(2) = z;
  T.t = {p.x(), p.y(), 0.25 * (wheel[0][0] + wheel[0][1] + wheel[1][0] + wheel[1][1])};
  return T;
}

// Two swings about each axis of the camera, of deviation sway_rad_ together.
Eigen::Matrix3d Course::sway(double time_s) const {
  static constexpr double kHz[3][2] = {{1.7, 3.7}, {1.1, 2.9}, {0.9, 2.3}};
  Eigen::Vector3d turn;
  for (int k = 0; k < 3; ++k) {
    turn[k] = sway_rad_ * (1.2 * std::sin(2.0 * kPi * kHz[k][0] * time_s + sway_phase_[k][0]) +
                           0.75 * std::sin(2.0 * kPi * kHz[k][1] * time_s + sway_phase_[k][1]));
  }
  return so3_exp(turn);
}

RigidTransform Course::T_body_camera() const {
  RigidTransform T;
  const double c = std::cos(pitch_rad_);
  const double sn = std::sin(pitch_rad_);
  T.R.col(2) = Eigen::Vector3d(c, 0.0, sn);
  T.R.col(0) = Eigen::Vector3d(0.0, -1.0, 0.0);
  T.R.col(1) = T.R.col(2).cross(T.R.col(0));
  T.t = {kCameraForwardM, 0.5 * baseline_m_, camera_height_m_};
  return T;
}

RigidTransform Course::T_world_camera(double frame) const {
  const double time_s = frame / rate_hz_;
  const double s = moves() ? step_m_ * frame : 0.0;
  RigidTransform T_world_body_now = T_world_body(s, 0.0);
  RigidTransform T_body_shaken;
  if (kind_ == Kind::walking) {
    const double step = 2.0 * kPi * 1.9 * time_s;  // a step; left and right alternate at half of it
    T_body_shaken.t = {0.008 * std::sin(step + phase_[3]), 0.016 * std::sin(0.5 * step), 0.020 * std::cos(step)};
    T_body_shaken.R =
        rotation_zyx(0.026 * std::sin(0.5 * step + 0.8), 0.020 * std::sin(step + 0.5), 0.030 * std::sin(0.5 * step));
  } else if (kind_ == Kind::wheeled || kind_ == Kind::straight) {
    // Roughness below what the terrain carries shakes the body, tied to the way and not to the time.
    const double w = 2.0 * kPi * s;
    T_body_shaken.t = {0.0, 0.0, 0.0012 * std::sin(w / 0.71) + 0.0008 * std::sin(w / 0.43 + 1.0)};
    T_body_shaken.R =
        rotation_zyx(0.0, 0.0012 * std::sin(w / 0.83 + 2.0) + 0.0008 * std::sin(w / 0.37), 0.0012 * std::sin(w / 0.61));
  }
  RigidTransform T = T_world_body_now * T_body_shaken * T_body_camera();
  if (kind_ == Kind::turn) {
    // About the left camera's centre and the vertical: 0.6 degrees a frame on average, never the same twice in a row.
    const double yaw = 2.0 * kPi / 180.0 * (0.3 * frame + 4.0 * std::sin(0.05 * frame));
    T.R = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix() * T.R;
  }
  if (sway_rad_ > 0.0) T.R = T.R * sway(time_s);
  return T;
}

}  // namespace cliquevo::drivers::sim
