// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/board_view.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/LU>

#include "drivers/simulator/gradient_noise.h"
#include "drivers/simulator/renderer.h"

namespace cliquevo::drivers::sim {

namespace {

constexpr double kWall_m = 5.0;
constexpr double kWallGrey = 95.0;
constexpr double kWallContrast = 70.0;
constexpr double kWallWaves = 1.5;  // a metre, of the coarsest texture
constexpr int kOctaves = 4;
constexpr float kWhite = 205.0F;
constexpr float kBlack = 26.0F;
constexpr double kLeastLight = 0.75;  // on a board that is seen from the side; one that faces the camera has 1
constexpr int kSubPixels = 8;         // across and down, where a pixel meets an edge
constexpr int kMargin_px = 3;

double wall_grey(const Eigen::Vector3d& p, std::uint64_t seed) {
  double sum = 0.0;
  double waves = kWallWaves;
  double share = 1.0;
  for (int k = 0; k < kOctaves; ++k, waves *= 2.1, share *= 0.6) {
    sum += share * gradient_noise(mix64(seed + static_cast<std::uint64_t>(k)), waves * (p.x() + 0.3 * p.z()),
                                  waves * (p.y() - 0.2 * p.z()));
  }
  return std::clamp(kWallGrey + kWallContrast * sum, 15.0, 190.0);
}

}  // namespace

double to_wall(const Eigen::Vector3d& from, const Eigen::Vector3d& ray) {
  const double along = from.dot(ray);
  return -along + std::sqrt(along * along + kWall_m * kWall_m - from.squaredNorm());
}

BoardView::BoardView(const BoardPattern& pattern, const CameraCalibration& camera, const RigidTransform& T_left_camera,
                     std::uint64_t seed)
    : pattern_(pattern), lens_(camera), wall_(camera.width, camera.height) {
  constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();
  rays_.reserve(static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height));
  for (int j = 0; j < camera.height; ++j) {
    std::uint16_t* row = wall_.view().row(j);
    for (int i = 0; i < camera.width; ++i) {
      const auto direction = lens_.direction(i, j);
      rays_.push_back(direction.value_or(Eigen::Vector3d::Constant(kNothing)));
      double grey = 0.0;
      if (direction) {
        const Eigen::Vector3d out = T_left_camera.R * *direction;
        grey = wall_grey(T_left_camera.t + to_wall(T_left_camera.t, out) * out, seed);
      }
      row[i] = static_cast<std::uint16_t>(std::lround(kGreyScale * grey));
    }
  }
}

Eigen::Vector3d BoardView::across(int i, int j) const {
  const int a = std::max(i - 1, 0), b = std::min(i + 1, lens_.camera().width - 1);
  return (ray(b, j) - ray(a, j)) / (b - a);
}

Eigen::Vector3d BoardView::down(int i, int j) const {
  const int a = std::max(j - 1, 0), b = std::min(j + 1, lens_.camera().height - 1);
  return (ray(i, b) - ray(i, a)) / (b - a);
}

BoardView::Row BoardView::row_at(const PoseAt& T_camera_board, const Shutter& shutter, int j) const {
  Row out;
  const double row_s = shutter.readout_s * ((j + 0.5) / lens_.camera().height - 0.5);
  for (int k = 0; k < kSlices; ++k) {
    const RigidTransform T = T_camera_board(row_s + shutter.exposure_s * ((k + 0.5) / kSlices - 0.5));
    Eigen::Matrix3d from_board;
    from_board << T.R.col(0), T.R.col(1), T.t;
    out.to_board[static_cast<std::size_t>(k)] = from_board.inverse();
    if (k == 0) {
      const Eigen::Vector3d middle = T * Eigen::Vector3d(pattern_.middle().x(), pattern_.middle().y(), 0.0);
      out.light = kLeastLight + (1.0 - kLeastLight) * std::abs(T.R.col(2).dot(middle.normalized()));
    }
  }
  return out;
}

// Where the sheet's outline goes during the exposure.
BoardView::Span BoardView::touched(const PoseAt& T_camera_board, const Shutter& shutter) const {
  const int width = lens_.camera().width, height = lens_.camera().height;
  Eigen::Vector2d low(width, height), high(-1.0, -1.0);
  const double half_s = 0.5 * (shutter.exposure_s + shutter.readout_s);
  for (const double later_s : {-half_s, 0.0, half_s}) {
    const RigidTransform T = T_camera_board(later_s);
    for (const Eigen::Vector3d& p : pattern_.outline()) {
      const auto px = lens_.project(T * p);
      if (!px) return {0, width, 0, height};
      low = low.cwiseMin(*px);
      high = high.cwiseMax(*px);
    }
  }
  // Straight edges are bent by the lens between the outline's points.
  const double margin = kMargin_px + 0.05 * (high - low).maxCoeff();
  const auto bounded = [](double v, int size) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(size)));
  };
  return {bounded(low.x() - margin, width), bounded(high.x() + margin + 1.0, width), bounded(low.y() - margin, height),
          bounded(high.y() + margin + 1.0, height)};
}

float BoardView::ink(const Row& row, int slice, const Eigen::Vector3d& ray, float behind) const {
  const Eigen::Vector3d p = row.to_board[static_cast<std::size_t>(slice)] * ray;
  if (!(p.z() > 0.0)) return behind;
  const BoardPattern::Ink ink = pattern_.at(p.x() / p.z(), p.y() / p.z()).ink;
  if (ink == BoardPattern::Ink::none) return behind;
  return static_cast<float>(row.light) * (ink == BoardPattern::Ink::white ? kWhite : kBlack);
}

float BoardView::pixel(const Row& row, int i, int j) const {
  const Eigen::Vector3d& middle = ray(i, j);
  const float behind = static_cast<float>(wall_.cview()(i, j)) / kGreyScale;
  if (!middle.allFinite()) return behind;
  const Eigen::Vector3d dx = across(i, j), dy = down(i, j);
  if (!dx.allFinite() || !dy.allFinite()) return behind;
  const auto place = [&](int slice, double x, double y) -> Eigen::Vector2d {
    const Eigen::Vector3d p = row.to_board[static_cast<std::size_t>(slice)] * (middle + x * dx + y * dy);
    return p.z() > 0.0 ? Eigen::Vector2d(p.head<2>() / p.z()) : Eigen::Vector2d::Constant(1e9);
  };
  const Eigen::Vector2d at = place(kSlices / 2, 0.0, 0.0);
  double reach = 0.0;
  for (const int slice : {0, kSlices - 1}) {
    for (const double x : {-0.5, 0.5}) {
      for (const double y : {-0.5, 0.5}) reach = std::max(reach, (place(slice, x, y) - at).norm());
    }
  }
  const auto here = pattern_.at(at.x(), at.y());
  if (here.clear_m > reach) return ink(row, kSlices / 2, middle, behind);
  float sum = 0.0F;
  for (int b = 0; b < kSubPixels; ++b) {
    for (int a = 0; a < kSubPixels; ++a) {
      const double x = (a + 0.5) / kSubPixels - 0.5, y = (b + 0.5) / kSubPixels - 0.5;
      sum += ink(row, (a + 2 * b) % kSlices, middle + x * dx + y * dy, behind);
    }
  }
  return sum / static_cast<float>(kSubPixels * kSubPixels);
}

void BoardView::render(const PoseAt& T_camera_board, const Shutter& shutter, Image<std::uint16_t>& out) const {
  out.copy_from(wall_.cview());
  const Span span = touched(T_camera_board, shutter);
  Row row;
  for (int j = span.j0; j < span.j1; ++j) {
    if (j == span.j0 || shutter.readout_s > 0.0) row = row_at(T_camera_board, shutter, j);
    std::uint16_t* to = out.view().row(j);
    for (int i = span.i0; i < span.i1; ++i)
      to[i] = static_cast<std::uint16_t>(std::lround(kGreyScale * pixel(row, i, j)));
  }
}

}  // namespace cliquevo::drivers::sim
