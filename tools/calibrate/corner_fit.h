// SPDX-License-Identifier: BSD-3-Clause
// Where two edges cross in an image: a model of the grey levels around the crossing is fitted to all pixels near it.
#pragma once

#include <array>
#include <optional>

#include <Eigen/Core>

#include "core/base/image.h"

namespace cliquevo::tools {

// Which pixels around a crossing show nothing but its two edges.
struct CornerWindow {
  // Along both edges, px for a unit of the board; the first one's column first.
  Eigen::Matrix2d px_of_board = Eigen::Matrix2d::Identity();
  double reach = 0.0;  // from the crossing along each edge, in units of the board
  double free = 0.0;   // beside an edge; farther off something else begins
  // Of each edge in the image, 1/px: a lens bends them.
  std::array<double, 2> curvature{};
};

// The crossing near `start`, to about a hundredth of a pixel; none where the pixels show no dark and bright quarters in
// turn.
std::optional<Eigen::Vector2d> fit_corner(ImageView<const std::uint8_t> image, const Eigen::Vector2d& start,
                                          const CornerWindow& window);

}  // namespace cliquevo::tools
