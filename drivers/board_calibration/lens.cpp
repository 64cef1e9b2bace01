// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/board_calibration/lens.h"

#include <cmath>
#include <unsupported/Eigen/AutoDiff>

namespace cliquevo::calibration {

namespace {

constexpr double kNearest = 1e-6;  // depth over distance of what a pinhole sees
constexpr double kOnAxis = 1e-12;

constexpr std::array<LensModel, 4> kModels{{
    {"radtan", Distortion::plumb_bob, {"k1", "k2", "p1", "p2"}, {0, 1, 2, 3}, 4},
    {"plumb_bob", Distortion::plumb_bob, {"k1", "k2", "p1", "p2", "k3"}, {0, 1, 2, 3, 4}, 5},
    {"rational", Distortion::rational, {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"}, {0, 1, 2, 3, 4, 5, 6, 7}, 8},
    {"equidistant", Distortion::equidistant, {"k1", "k2", "k3", "k4"}, {0, 1, 2, 3}, 4},
}};

using Derivatives = Eigen::Matrix<double, 3 + kMostLens, 1>;
using Number = Eigen::AutoDiffScalar<Derivatives>;

template <typename T>
struct Pixel {
  T u, v;
};

// k1 k2 p1 p2 k3 k4 k5 k6 on the plane in front of the camera; those that a model lacks are 0.
double value_of(double x) { return x; }
double value_of(const Number& x) { return x.value(); }

template <typename T>
Pixel<T> through_pinhole(const std::array<T, kMostLens>& c, const T& X, const T& Y, const T& Z, bool rational) {
  const T x = X / Z, y = Y / Z;
  const T r2 = x * x + y * y;
  T scale = T(1.0) + r2 * (c[4] + r2 * (c[5] + r2 * c[8]));
  if (rational) scale = scale / (T(1.0) + r2 * (c[9] + r2 * (c[10] + r2 * c[11])));
  const T xy = x * y;
  const T xd = x * scale + T(2.0) * c[6] * xy + c[7] * (r2 + T(2.0) * x * x);
  const T yd = y * scale + c[6] * (r2 + T(2.0) * y * y) + T(2.0) * c[7] * xy;
  return {c[0] * xd + c[2], c[1] * yd + c[3]};
}

template <typename T>
Pixel<T> through_fisheye(const std::array<T, kMostLens>& c, const T& X, const T& Y, const T& Z) {
  using std::atan2;
  using std::sqrt;
  const T r2 = X * X + Y * Y;
  if (value_of(r2) < kOnAxis) return {c[0] * X / Z + c[2], c[1] * Y / Z + c[3]};
  const T r = sqrt(r2);
  const T angle = atan2(r, Z);
  const T a2 = angle * angle;
  const T bent = angle * (T(1.0) + a2 * (c[4] + a2 * (c[5] + a2 * (c[6] + a2 * c[7]))));
  return {c[0] * bent * X / r + c[2], c[1] * bent * Y / r + c[3]};
}

template <typename T>
Pixel<T> through_lens(const LensModel& model, const std::array<T, kMostLens>& c, const T& X, const T& Y, const T& Z) {
  return model.distortion == Distortion::equidistant
             ? through_fisheye(c, X, Y, Z)
             : through_pinhole(c, X, Y, Z, model.distortion == Distortion::rational);
}

bool reaches(const LensModel& model, const Eigen::Vector3d& point) {
  const double distance = point.norm();
  return distance > 0.0 && (model.distortion == Distortion::equidistant || point.z() >= kNearest * distance);
}

}  // namespace

std::string LensModel::parameter_name(int index) const {
  static constexpr std::array<const char*, kFocalAndCentre> kFirst{"fx_px", "fy_px", "cx_px", "cy_px"};
  return index < kFocalAndCentre ? kFirst[static_cast<std::size_t>(index)]
                                 : names[static_cast<std::size_t>(index - kFocalAndCentre)];
}

std::span<const LensModel> lens_models() { return kModels; }

const LensModel* find_lens_model(const std::string& name) {
  for (const LensModel& model : kModels) {
    if (name == model.name) return &model;
  }
  return nullptr;
}

Projection project_with_derivatives(const LensModel& model, const LensVector& lens, const Eigen::Vector3d& point) {
  Projection out;
  if (!reaches(model, point)) return out;
  std::array<Number, kMostLens> c;
  for (int i = 0; i < kMostLens; ++i) c[static_cast<std::size_t>(i)] = Number(lens(i), 3 + kMostLens, 3 + i);
  const Number X(point.x(), 3 + kMostLens, 0), Y(point.y(), 3 + kMostLens, 1), Z(point.z(), 3 + kMostLens, 2);
  const Pixel<Number> px = through_lens(model, c, X, Y, Z);
  out.px << px.u.value(), px.v.value();
  out.by_point.row(0) = px.u.derivatives().head<3>().transpose();
  out.by_point.row(1) = px.v.derivatives().head<3>().transpose();
  out.by_lens.row(0) = px.u.derivatives().tail<kMostLens>().transpose();
  out.by_lens.row(1) = px.v.derivatives().tail<kMostLens>().transpose();
  out.seen = out.px.allFinite() && out.by_point.allFinite() && out.by_lens.allFinite();
  return out;
}

std::optional<Eigen::Vector2d> project(const LensModel& model, const LensVector& lens, const Eigen::Vector3d& point) {
  if (!reaches(model, point)) return std::nullopt;
  std::array<double, kMostLens> c;
  for (int i = 0; i < kMostLens; ++i) c[static_cast<std::size_t>(i)] = lens(i);
  const Pixel<double> px = through_lens(model, c, point.x(), point.y(), point.z());
  if (!std::isfinite(px.u) || !std::isfinite(px.v)) return std::nullopt;
  return Eigen::Vector2d(px.u, px.v);
}

Eigen::Vector3d ideal_ray(const LensModel& model, const LensVector& lens, const Eigen::Vector2d& px) {
  const double x = (px.x() - lens(2)) / lens(0);
  const double y = (px.y() - lens(3)) / lens(1);
  if (model.distortion != Distortion::equidistant) return Eigen::Vector3d(x, y, 1.0).normalized();
  const double angle = std::hypot(x, y);
  if (angle < kOnAxis) return Eigen::Vector3d::UnitZ();
  const double along = std::sin(angle) / angle;
  return {x * along, y * along, std::cos(angle)};
}

CameraCalibration to_camera(const LensModel& model, const LensVector& lens, int width, int height) {
  CameraCalibration camera;
  camera.width = width;
  camera.height = height;
  camera.fx_px = lens(0);
  camera.fy_px = lens(1);
  camera.cx_px = lens(2);
  camera.cy_px = lens(3);
  camera.distortion = model.distortion;
  for (int i = 0; i < model.coefficients; ++i) {
    camera.coefficients[static_cast<std::size_t>(model.places[static_cast<std::size_t>(i)])] =
        lens(kFocalAndCentre + i);
  }
  return camera;
}

}  // namespace cliquevo::calibration
