// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/board_calibration/accuracy.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "stereo/camera_projection.h"
#include "stereo/rectification.h"

namespace cliquevo::calibration {

namespace {

constexpr double kDegrees = 180.0 / M_PI;
constexpr int kPlacesAcross = 7;
constexpr int kPlacesDown = 5;
constexpr int kCellsAcross = 8;
constexpr int kCellsDown = 6;

// A point that both cameras see, as pixels.
struct Seen {
  Eigen::Vector2d left;
  Eigen::Vector2d right;
};

bool inside(const Eigen::Vector2d& px, const CameraCalibration& c) {
  return px.x() >= 0.0 && px.y() >= 0.0 && px.x() <= c.width - 1 && px.y() <= c.height - 1;
}

// Points at one depth over the image that the cameras share.
std::vector<Seen> seen_at(const StereoCalibration& c, double depth_m) {
  const stereo::CameraProjection left(c.left), right(c.right);
  std::vector<Seen> out;
  for (int j = 0; j < kPlacesDown; ++j) {
    for (int i = 0; i < kPlacesAcross; ++i) {
      const double u = (i + 0.5) * c.left.width / kPlacesAcross;
      const double v = (j + 0.5) * c.left.height / kPlacesDown;
      const auto direction = left.direction(u, v);
      if (!direction) continue;
      const Eigen::Vector3d p = *direction * depth_m;
      const auto in_right = right.project(c.T_right_left * p);
      const auto in_left = left.project(p);
      if (in_right && in_left && inside(*in_right, c.right)) out.push_back({*in_left, *in_right});
    }
  }
  return out;
}

// Depth at which the rays of both pixels come closest; NaN where there is none.
struct Triangulation {
  double depth_m = std::numeric_limits<double>::quiet_NaN();
};

class Rays {
 public:
  explicit Rays(const StereoCalibration& c) : left_(c.left), right_(c.right), T_left_right_(c.T_right_left.inverse()) {}

  Triangulation at(const Seen& seen) const {
    const auto l = left_.direction(seen.left.x(), seen.left.y());
    const auto r = right_.direction(seen.right.x(), seen.right.y());
    if (!l || !r) return {};
    const Eigen::Vector3d d = T_left_right_.R * *r;
    // a l - b d = t: least squares.
    Eigen::Matrix<double, 3, 2> A;
    A << *l, -d;
    const Eigen::Matrix2d normal = A.transpose() * A;
    const Eigen::Vector2d ab = normal.ldlt().solve(A.transpose() * T_left_right_.t);
    return {ab.x() * l->z()};
  }

 private:
  stereo::CameraProjection left_;
  stereo::CameraProjection right_;
  RigidTransform T_left_right_;
};

// Columns whose products make up the covariance: one standard deviation each.
std::vector<Eigen::Matrix<double, kShared, 1>> deviations(const Eigen::Matrix<double, kShared, kShared>& covariance) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, kShared, kShared>> solver(covariance);
  std::vector<Eigen::Matrix<double, kShared, 1>> out;
  const double most = solver.eigenvalues().maxCoeff();
  for (int i = 0; i < kShared; ++i) {
    const double value = solver.eigenvalues()(i);
    if (value > 1e-16 * most) out.push_back(std::sqrt(value) * solver.eigenvectors().col(i));
  }
  return out;
}

struct DepthSpread {
  double rms_m = 0.0;     // over places
  double common_m = 0.0;  // what all places share
};

DepthSpread depth_spread(const Rig& rig, const Eigen::Matrix<double, kShared, kShared>& covariance, double depth_m) {
  const StereoCalibration nominal = rig.calibration();
  const std::vector<Seen> seen = seen_at(nominal, depth_m);
  const Rays rays(nominal);
  double squared = 0.0;
  double common = 0.0;
  double places = 0.0;
  for (const auto& step : deviations(covariance)) {
    const Rays moved(rig.moved(step).calibration());
    double sum = 0.0;
    places = 0.0;
    for (const Seen& s : seen) {
      const double change = moved.at(s).depth_m - rays.at(s).depth_m;
      if (!std::isfinite(change)) continue;
      sum += change;
      squared += change * change;
      places += 1.0;
    }
    if (places > 0.0) common += sum * sum / (places * places);
  }
  if (!(places > 0.0)) return {};
  return {std::sqrt(squared / places), std::sqrt(common)};
}

// Words for the largest part of a 3 x 3 division of the image in which no corner was seen.
std::string hole_of(const std::vector<View>& views, Side side, int width, int height) {
  int count[3][3] = {};
  for (const View& view : views) {
    for (const SeenCorner& c : view.of(side)) {
      const int i = std::clamp(static_cast<int>(3.0 * c.px.x() / width), 0, 2);
      const int j = std::clamp(static_cast<int>(3.0 * c.px.y() / height), 0, 2);
      ++count[j][i];
    }
  }
  static constexpr const char* kAcross[] = {"left", "middle", "right"};
  static constexpr const char* kDown[] = {"upper", "middle", "lower"};
  for (int j = 0; j < 3; ++j) {
    for (int i = 0; i < 3; ++i) {
      if (count[j][i] > 0) continue;
      const std::string where = i == 1 && j == 1 ? "middle" : fmt::format("{} {}", kDown[j], kAcross[i]);
      return fmt::format("{} part of the {} image", where, side == Side::left ? "left" : "right");
    }
  }
  return "";
}

double filled_cells(const std::vector<View>& views, Side side, int width, int height) {
  std::array<bool, kCellsAcross * kCellsDown> seen{};
  for (const View& view : views) {
    for (const SeenCorner& c : view.of(side)) {
      const int i = std::clamp(static_cast<int>(kCellsAcross * c.px.x() / width), 0, kCellsAcross - 1);
      const int j = std::clamp(static_cast<int>(kCellsDown * c.px.y() / height), 0, kCellsDown - 1);
      seen[static_cast<std::size_t>(j) * kCellsAcross + static_cast<std::size_t>(i)] = true;
    }
  }
  return static_cast<double>(std::count(seen.begin(), seen.end(), true)) / static_cast<double>(seen.size());
}

}  // namespace

Accuracy accuracy(const Rig& rig, const Eigen::Matrix<double, kShared, kShared>& covariance) {
  Accuracy out;
  for (std::size_t i = 0; i < kJudgedDepths_m.size(); ++i) {
    const DepthSpread spread = depth_spread(rig, covariance, kJudgedDepths_m[i]);
    out.depth_m[i] = spread.rms_m;
    if (i == 0) out.drift_percent = 100.0 * spread.common_m / kJudgedDepths_m[i];
  }
  out.rotation_deg = kDegrees * std::sqrt(covariance.block<3, 3>(kFirstOfPose + 3, kFirstOfPose + 3).trace());
  // t' = exp(w) t + d: a rotation keeps the length.
  const Eigen::Vector3d along = rig.T_right_left.t.normalized();
  out.baseline_m = std::sqrt(along.dot(covariance.block<3, 3>(kFirstOfPose, kFirstOfPose) * along));
  return out;
}

Coverage coverage(const Board& board, const Solution& s) {
  Coverage out;
  const Rig& rig = s.rig();
  out.nearest_m = std::numeric_limits<double>::infinity();
  const Eigen::Vector3d middle(board.middle().x(), board.middle().y(), 0.0);
  double least = 1.0;
  for (std::size_t a = 0; a < s.views.size(); ++a) {
    const RigidTransform& T = s.adjusted.T_left_board[a];
    const double distance = (T * middle).norm();
    out.nearest_m = std::min(out.nearest_m, distance);
    out.farthest_m = std::max(out.farthest_m, distance);
    for (std::size_t b = 0; b < a; ++b) {
      least = std::min(least, std::abs(T.R.col(2).dot(s.adjusted.T_left_board[b].R.col(2))));
    }
  }
  out.tilt_deg = kDegrees * std::acos(std::clamp(least, -1.0, 1.0));
  for (const Side side : {Side::left, Side::right}) {
    out.filled[static_cast<std::size_t>(side)] = filled_cells(s.views, side, rig.width, rig.height);
    if (out.hole.empty()) out.hole = hole_of(s.views, side, rig.width, rig.height);
  }
  return out;
}

Movement movement(const Rig& rig, const Eigen::Matrix<double, kShared, kShared>& covariance,
                  const StereoCalibration& other) {
  Movement out;
  const StereoCalibration mine = rig.calibration();
  const Rays rays(other);
  for (std::size_t i = 0; i < kJudgedDepths_m.size(); ++i) {
    const double depth_m = kJudgedDepths_m[i];
    double sum = 0.0;
    double places = 0.0;
    for (const Seen& s : seen_at(mine, depth_m)) {
      const double depth = rays.at(s).depth_m;
      if (!std::isfinite(depth)) continue;
      sum += depth - depth_m;
      places += 1.0;
    }
    out.depth_m[i] = places > 0.0 ? sum / places : 0.0;
    const double sigma = depth_spread(rig, covariance, depth_m).common_m;
    out.depth_sigmas[i] = sigma > 0.0 ? out.depth_m[i] / sigma : 0.0;
  }
  out.rotation_deg = kDegrees * (mine.T_right_left.inverse() * other.T_right_left).angle();
  const auto rectification = stereo::choose_rectification(other);
  if (!rectification) return out;
  const stereo::CameraProjection left(other.left), right(other.right);
  const StereoModel& m = rectification->model;
  double squared = 0.0;
  double places = 0.0;
  for (const Seen& s : seen_at(mine, kJudgedDepths_m[1])) {
    const auto l = left.direction(s.left.x(), s.left.y());
    const auto r = right.direction(s.right.x(), s.right.y());
    if (!l || !r) continue;
    const Eigen::Vector3d a = rectification->R_left * *l;
    const Eigen::Vector3d b = rectification->R_right * *r;
    if (a.z() < 1e-3 || b.z() < 1e-3) continue;
    const double rows = m.fy_px * (a.y() / a.z() - b.y() / b.z());
    squared += rows * rows;
    places += 1.0;
  }
  out.rows_px = places > 0.0 ? std::sqrt(squared / places) : 0.0;
  return out;
}

}  // namespace cliquevo::calibration
