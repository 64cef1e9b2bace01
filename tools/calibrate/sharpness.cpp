// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/sharpness.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Eigenvalues>

namespace cliquevo::tools {

namespace {

using calibration::SeenCorner;

constexpr double kWindowOfSpacing = 0.35;
constexpr int kLeastHalf = 3;
constexpr int kMostHalf = 8;
constexpr double kLeastContrast = 20.0;  // grey levels

int half_window(const std::vector<SeenCorner>& corners) {
  double least = 1e9;
  for (std::size_t i = 1; i < corners.size(); ++i) least = std::min(least, (corners[i].px - corners[i - 1].px).norm());
  return std::clamp(static_cast<int>(kWindowOfSpacing * least), kLeastHalf, kMostHalf);
}

// An edge of contrast C and width w has the energy C^2 / w of its gradient, a pixel of its length.
std::optional<double> width_at(ImageView<const std::uint8_t> image, const Eigen::Vector2d& px, int half) {
  const int x = static_cast<int>(std::lround(px.x())), y = static_cast<int>(std::lround(px.y()));
  if (x - half < 1 || y - half < 1 || x + half > image.width - 2 || y + half > image.height - 2) return std::nullopt;
  Eigen::Matrix2d energy = Eigen::Matrix2d::Zero();
  std::vector<std::uint8_t> levels;
  for (int j = y - half; j <= y + half; ++j) {
    for (int i = x - half; i <= x + half; ++i) {
      const Eigen::Vector2d gradient(0.5 * (image(i + 1, j) - image(i - 1, j)),
                                     0.5 * (image(i, j + 1) - image(i, j - 1)));
      energy += gradient * gradient.transpose();
      levels.push_back(image(i, j));
    }
  }
  std::sort(levels.begin(), levels.end());
  const double contrast = levels[levels.size() - 1 - levels.size() / 10] - levels[levels.size() / 10];
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> solver(energy, Eigen::EigenvaluesOnly);
  const double least = solver.eigenvalues()(0);
  if (contrast < kLeastContrast || !(least > 0.0)) return std::nullopt;
  return contrast * contrast * (2 * half + 1) / least;
}

}  // namespace

double edge_width_px(ImageView<const std::uint8_t> image, const std::vector<SeenCorner>& corners) {
  if (corners.empty()) return 0.0;
  const int half = half_window(corners);
  std::vector<double> widths;
  for (const SeenCorner& corner : corners) {
    if (const auto width = width_at(image, corner.px, half)) widths.push_back(*width);
  }
  if (widths.empty()) return 0.0;
  const auto middle = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
  std::nth_element(widths.begin(), middle, widths.end());
  return *middle;
}

}  // namespace cliquevo::tools
