// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/board_calibration/start.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>

namespace cliquevo::calibration {

namespace {

constexpr std::size_t kCornersOfAHomography = 4;
// Focal lengths to begin with, over the image's width: 110 to 18 degrees across for a pinhole, 280 to 57 for a fisheye.
constexpr std::array<double, 8> kPinholeFocal{0.35, 0.5, 0.7, 0.9, 1.2, 1.6, 2.2, 3.2};
constexpr std::array<double, 8> kFisheyeFocal{0.2, 0.25, 0.3, 0.37, 0.45, 0.55, 0.7, 1.0};
constexpr std::size_t kTried = 3;      // of the best are adjusted, until one fits:
constexpr double kFitsOfWidth = 1e-3;  // sigma of a corner, of the image's width

struct Guess {
  LensVector lens = LensVector::Zero();
  std::vector<RigidTransform> T_camera_board;
  double error = 0.0;  // mean squared angle between rays and the rigid board
};

Guess guess_with(const Board& board, const std::vector<View>& views, const LensModel& rays_of, double focal_px,
                 int width, int height) {
  Guess guess;
  guess.lens.head<4>() << focal_px, focal_px, 0.5 * (width - 1), 0.5 * (height - 1);
  double squared = 0.0;
  double count = 0.0;
  for (const View& view : views) {
    std::vector<Eigen::Vector3d> rays;
    for (const SeenCorner& corner : view.left) rays.push_back(ideal_ray(rays_of, guess.lens, corner.px));
    RigidTransform pose;
    pose.t.z() = 1.0;
    if (const auto found = pose_from_rays(board, view.left, rays)) pose = *found;
    guess.T_camera_board.push_back(pose);
    for (std::size_t i = 0; i < rays.size(); ++i) {
      squared += (rays[i] - (pose * board.corner(view.left[i].id)).normalized()).squaredNorm();
      count += 1.0;
    }
  }
  // By the image: an angle is worth fewer pixels where the focal length is short.
  guess.error = squared / std::max(1.0, count) * focal_px * focal_px;
  return guess;
}

SharedMask lens_mask(std::initializer_list<int> of) {
  SharedMask mask{};
  for (const int i : of) mask[static_cast<std::size_t>(i)] = true;
  return mask;
}

SharedMask whole_lens(const LensModel& model) {
  SharedMask mask{};
  for (int i = 0; i < model.size(); ++i) mask[static_cast<std::size_t>(i)] = true;
  return mask;
}

// Focal length first, then what bends most, then all.
Adjusted adjust_in_steps(const Board& board, const std::vector<View>& views, const LensModel& model, const Guess& guess,
                         int width, int height) {
  Rig rig;
  rig.model = &model;
  rig.left = guess.lens;
  rig.width = width;
  rig.height = height;
  AdjustmentOptions options;
  options.estimated = lens_mask({0, kFocalAndCentre});
  options.square_pixels = true;
  options.most_iterations = 20;
  Adjusted state = adjust(board, views, rig, guess.T_camera_board, options);
  options.square_pixels = false;
  options.estimated = lens_mask({0, 1, 2, 3, kFocalAndCentre, kFocalAndCentre + 1});
  state = adjust(board, views, state.rig, state.T_left_board, options);
  options.estimated = whole_lens(model);
  options.most_iterations = 60;
  return adjust(board, views, state.rig, state.T_left_board, options);
}

}  // namespace

std::optional<RigidTransform> pose_from_rays(const Board& board, const std::vector<SeenCorner>& corners,
                                             const std::vector<Eigen::Vector3d>& rays) {
  if (corners.size() < kCornersOfAHomography) return std::nullopt;
  const double scale = board.half_extent().norm();
  const Eigen::Vector2d middle = board.middle();
  Eigen::Matrix<double, 9, 9> A = Eigen::Matrix<double, 9, 9>::Zero();
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d at = board.corner(corners[i].id);
    const Eigen::Vector3d b((at.x() - middle.x()) / scale, (at.y() - middle.y()) / scale, 1.0);
    const Eigen::Matrix3d across = skew(rays[i]);
    Eigen::Matrix<double, 3, 9> rows;  // ray x (H b) = 0, H by columns
    rows << b.x() * across, b.y() * across, b.z() * across;
    A += rows.transpose() * rows;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> solver(A);
  const Eigen::Matrix<double, 9, 1> h = solver.eigenvectors().col(0);
  Eigen::Matrix3d H = Eigen::Map<const Eigen::Matrix3d>(h.data());
  const double length = std::sqrt(H.col(0).norm() * H.col(1).norm());
  if (!(length > 1e-12) || !H.allFinite()) return std::nullopt;
  H /= length;
  double before = 0.0;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector3d at = board.corner(corners[i].id);
    const Eigen::Vector3d b((at.x() - middle.x()) / scale, (at.y() - middle.y()) / scale, 1.0);
    before += rays[i].dot(H * b);
  }
  if (before < 0.0) H = -H;
  Eigen::Matrix3d axes;
  axes << H.col(0), H.col(1), H.col(0).cross(H.col(1));
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(axes, Eigen::ComputeFullU | Eigen::ComputeFullV);
  RigidTransform pose;
  pose.R = svd.matrixU() * svd.matrixV().transpose();
  if (pose.R.determinant() < 0.0) return std::nullopt;
  pose.t = scale * H.col(2) - pose.R.leftCols<2>() * middle;
  if (!pose.is_finite()) return std::nullopt;
  return pose;
}

std::optional<OneCamera> calibrate_one(const Board& board, const std::vector<View>& views, const LensModel& model,
                                       int width, int height) {
  std::vector<Guess> guesses;
  guesses.reserve(std::size(kPinholeFocal) + std::size(kFisheyeFocal));
  // Poses do not depend on the lens model: those from a fisheye's rays may be the better start for a wide pinhole.
  const LensModel& pinhole = *find_lens_model("radtan");
  const LensModel& fisheye = *find_lens_model("equidistant");
  for (const double share : kPinholeFocal) {
    guesses.push_back(guess_with(board, views, pinhole, share * width, width, height));
  }
  for (const double share : kFisheyeFocal) {
    guesses.push_back(guess_with(board, views, fisheye, share * width, width, height));
  }
  std::sort(guesses.begin(), guesses.end(), [](const Guess& a, const Guess& b) { return a.error < b.error; });
  std::optional<OneCamera> best;
  for (std::size_t i = 0; i < kTried && i < guesses.size(); ++i) {
    const Adjusted state = adjust_in_steps(board, views, model, guesses[i], width, height);
    if (!state.rig.left.allFinite() || !std::isfinite(state.sigma_px) || !(state.rig.left(0) > 0.0)) continue;
    if (best && !(state.sigma_px < 0.99 * best->sigma_px)) continue;
    best = OneCamera{state.rig.left, state.T_left_board, state.sigma_px};
    if (best->sigma_px < kFitsOfWidth * width) break;
  }
  return best;
}

}  // namespace cliquevo::calibration
