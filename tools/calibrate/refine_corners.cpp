// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/refine_corners.h"

#include <cmath>
#include <limits>
#include <optional>

#include <Eigen/QR>

#include "tools/calibrate/corner_fit.h"

namespace cliquevo::tools {

namespace {

using calibration::Board;
using calibration::BoardKind;
using calibration::SeenCorner;

constexpr double kReachOfSide = 0.75;  // along an edge; at 1 is the next corner
constexpr double kFreeOfTag = 0.125;   // of a tag's side: farther in, its bits begin
// The board's image as polynomials: of the corners as they are found, then of those that were fitted.
constexpr int kFirstOrder = 3;
constexpr int kSecondOrder = 5;
constexpr int kCornersOfTerm = 2;  // at least, for a coefficient

// What a corner shows undisturbed, in metres of the board.
struct Undisturbed {
  double reach_m = 0.0;
  double free_m = std::numeric_limits<double>::infinity();
};

Undisturbed undisturbed(const Board& b) {
  if (b.kind == BoardKind::charuco) return {kReachOfSide * b.size_m, 0.5 * (1.0 - b.ratio) * b.size_m};
  if (b.kind == BoardKind::aprilgrid) return {kReachOfSide * b.ratio * b.size_m, kFreeOfTag * b.size_m};
  return {kReachOfSide * b.size_m, std::numeric_limits<double>::infinity()};
}

// Where the board's places are in the image: polynomials of both coordinates, by least squares.
class BoardMap {
 public:
  // Of this order, or a lower one where the corners are too few. None where they lie on one line.
  static std::optional<BoardMap> make(const Board& board, const std::vector<SeenCorner>& corners, int order) {
    for (; order >= 1; --order) {
      BoardMap map(board, order);
      if (map.terms() * (order > 1 ? kCornersOfTerm : 1) <= static_cast<int>(corners.size()) && map.fit(corners))
        return map;
    }
    return std::nullopt;
  }

  CornerWindow window(int id) const {
    const Eigen::Vector2d at = place(id);
    CornerWindow out;
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d along = derivative(at, axis, 1), bend = derivative(at, axis, 2);
      out.px_of_board.col(axis) = along.cwiseProduct(Eigen::Vector2d::Constant(1.0 / scale_m_));
      const Eigen::Vector2d normal = Eigen::Vector2d(-along.y(), along.x()).normalized();
      out.curvature[static_cast<std::size_t>(axis)] = normal.dot(bend) / along.squaredNorm();
    }
    return out;
  }

 private:
  BoardMap(const Board& board, int order)
      : board_(board), order_(order), middle_(board.middle()), scale_m_(board.half_extent().maxCoeff()) {}

  int terms() const { return (order_ + 1) * (order_ + 2) / 2; }
  Eigen::Vector2d place(int id) const { return (board_.corner(id).head<2>() - middle_) / scale_m_; }

  // x^i y^j, derived so often by one of both.
  Eigen::RowVectorXd row(const Eigen::Vector2d& at, int axis, int times) const {
    const auto power = [](double v, int n, int derived) {
      double factor = 1.0;
      for (int k = 0; k < derived; ++k) factor *= n - k;
      return n < derived ? 0.0 : factor * std::pow(v, n - derived);
    };
    Eigen::RowVectorXd out(terms());
    int next = 0;
    for (int i = 0; i <= order_; ++i) {
      for (int j = 0; i + j <= order_; ++j) {
        out(next++) = power(at.x(), i, axis == 0 ? times : 0) * power(at.y(), j, axis == 1 ? times : 0);
      }
    }
    return out;
  }

  bool fit(const std::vector<SeenCorner>& corners) {
    const auto count = static_cast<Eigen::Index>(corners.size());
    Eigen::MatrixXd A(count, terms());
    Eigen::MatrixX2d px(count, 2);
    for (Eigen::Index i = 0; i < count; ++i) {
      const SeenCorner& corner = corners[static_cast<std::size_t>(i)];
      A.row(i) = row(place(corner.id), 0, 0);
      px.row(i) = corner.px.transpose();
    }
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(A);
    coefficients_ = qr.solve(px);
    return qr.rank() == terms();
  }

  Eigen::Vector2d derivative(const Eigen::Vector2d& at, int axis, int times) const {
    return (row(at, axis, times) * coefficients_).transpose();
  }

  const Board& board_;
  int order_;
  Eigen::Vector2d middle_;
  double scale_m_;
  Eigen::MatrixX2d coefficients_;
};

}  // namespace

void refine_corners(ImageView<const std::uint8_t> image, const Board& board, std::vector<SeenCorner>& corners) {
  if (board.kind == BoardKind::circles) return;
  const Undisturbed shown = undisturbed(board);
  std::vector<SeenCorner> fitted = corners;  // those that lead to where the edges run
  for (const int order : {kFirstOrder, kSecondOrder}) {
    const auto map = BoardMap::make(board, fitted, order);
    if (!map) return;
    fitted.clear();
    for (SeenCorner& corner : corners) {
      CornerWindow window = map->window(corner.id);
      window.reach = shown.reach_m;
      window.free = shown.free_m;
      const auto px = fit_corner(image, corner.px, window);
      if (!px) continue;
      corner.px = *px;
      fitted.push_back(corner);
    }
  }
}

}  // namespace cliquevo::tools
