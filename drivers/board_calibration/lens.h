// SPDX-License-Identifier: BSD-3-Clause
// Lens models as the solver sees them: a vector of parameters, and the pixel of a point with its derivatives.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "core/base/camera_model.h"

namespace cliquevo::calibration {

inline constexpr int kFocalAndCentre = 4;  // fx, fy, cx, cy in px come first
inline constexpr int kMostLens = 12;       // parameters of a lens

struct LensModel {
  const char* name;                              // on the command line
  Distortion distortion;                         // as calibrations name it
  std::array<const char*, kMostLens - 4> names;  // of the coefficients, in the solver's order
  std::array<int, kMostLens - 4> places;         // in CameraCalibration::coefficients
  int coefficients = 0;

  int size() const { return kFocalAndCentre + coefficients; }
  std::string parameter_name(int index) const;
};

// A row a model, simplest first.
std::span<const LensModel> lens_models();
const LensModel* find_lens_model(const std::string& name);

using LensVector = Eigen::Matrix<double, kMostLens, 1>;  // unused ones are 0

struct Projection {
  bool seen = false;  // the model reaches there
  Eigen::Vector2d px = Eigen::Vector2d::Zero();
  Eigen::Matrix<double, 2, 3> by_point = Eigen::Matrix<double, 2, 3>::Zero();
  Eigen::Matrix<double, 2, kMostLens> by_lens = Eigen::Matrix<double, 2, kMostLens>::Zero();
};

// Of a point in the camera's frame (Z forward).
Projection project_with_derivatives(const LensModel& model, const LensVector& lens, const Eigen::Vector3d& point);

// The pixel alone; none where the model does not reach.
std::optional<Eigen::Vector2d> project(const LensModel& model, const LensVector& lens, const Eigen::Vector3d& point);

// Direction of a pixel by focal length and centre alone, without distortion; unit length.
Eigen::Vector3d ideal_ray(const LensModel& model, const LensVector& lens, const Eigen::Vector2d& px);

CameraCalibration to_camera(const LensModel& model, const LensVector& lens, int width, int height);

}  // namespace cliquevo::calibration
