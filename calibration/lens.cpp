// SPDX-License-Identifier: BSD-3-Clause
#include "calibration/lens.h"

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

struct Pixel {
  Number u, v;
};

// k1 k2 p1 p2 k3 k4 k5 k6 on the plane in front of the camera; those that a model lacks are 0.
Pixel through_pinhole(const std::array<Number, kMostLens>& c, const Number& X, const Number& Y, const Number& Z,
                      bool rational) {
  const Number x = X / Z, y = Y / Z;
  const Number r2 = x * x + y * y;
  Number scale = Number(1.0) + r2 * (c[4] + r2 * (c[5] + r2 * c[8]));
  if (rational) scale = scale / (Number(1.0) + r2 * (c[9] + r2 * (c[10] + r2 * c[11])));
  const Number xy = x * y;
  const Number xd = x * scale + Number(2.0) * c[6] * xy + c[7] * (r2 + Number(2.0) * x * x);
  const Number yd = y * scale + c[6] * (r2 + Number(2.0) * y * y) + Number(2.0) * c[7] * xy;
  return {c[0] * xd + c[2], c[1] * yd + c[3]};
}

Pixel through_fisheye(const std::array<Number, kMostLens>& c, const Number& X, const Number& Y, const Number& Z) {
  using std::atan2;
  using std::sqrt;
  const Number r2 = X * X + Y * Y;
  if (r2.value() < kOnAxis) return {c[0] * X / Z + c[2], c[1] * Y / Z + c[3]};
  const Number r = sqrt(r2);
  const Number angle = atan2(r, Z);
  const Number a2 = angle * angle;
  const Number bent = angle * (Number(1.0) + a2 * (c[4] + a2 * (c[5] + a2 * (c[6] + a2 * c[7]))));
  return {c[0] * bent * X / r + c[2], c[1] * bent * Y / r + c[3]};
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
  const bool fisheye = model.distortion == Distortion::equidistant;
  const double distance = point.norm();
  if (!(distance > 0.0) || (!fisheye && point.z() < kNearest * distance)) return out;
  std::array<Number, kMostLens> c;
  for (int i = 0; i < kMostLens; ++i) c[static_cast<std::size_t>(i)] = Number(lens(i), 3 + kMostLens, 3 + i);
  const Number X(point.x(), 3 + kMostLens, 0), Y(point.y(), 3 + kMostLens, 1), Z(point.z(), 3 + kMostLens, 2);
  const Pixel px =
      fisheye ? through_fisheye(c, X, Y, Z) : through_pinhole(c, X, Y, Z, model.distortion == Distortion::rational);
  out.px << px.u.value(), px.v.value();
  out.by_point.row(0) = px.u.derivatives().head<3>().transpose();
  out.by_point.row(1) = px.v.derivatives().head<3>().transpose();
  out.by_lens.row(0) = px.u.derivatives().tail<kMostLens>().transpose();
  out.by_lens.row(1) = px.v.derivatives().tail<kMostLens>().transpose();
  out.seen = out.px.allFinite() && out.by_point.allFinite() && out.by_lens.allFinite();
  return out;
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
