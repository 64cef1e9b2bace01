// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/corner_fit.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace cliquevo::tools {

namespace {

constexpr double kMostReach_px = 14.0;   // farther along its edges a corner gains little, and a lens bends them
constexpr double kLeastReach_px = 2.0;   // of an edge: less is no edge
constexpr double kBlurredInto_px = 0.7;  // what is beside an edge is blurred so far into what is free
constexpr double kMostFree_px = 4.0;     // farther off nothing changes
constexpr double kLeastFree_px = 0.8;    // beside an edge: with less it is not seen by itself
constexpr double kHalfPixel = 0.5;       // a pixel shows the mean of its area
constexpr double kFirstBlur_px = 0.4;    // scale of an edge's profile
constexpr double kLeastBlur_px = 0.05;
constexpr double kWidestBlur_px = 4.0;
constexpr double kMostMoved_px = 1.0;       // of the place to begin with
constexpr double kLeastHalfContrast = 5.0;  // half, grey levels
constexpr double kMostLeftOver = 0.3;       // RMS of the residuals, of half the contrast: else it is another pattern
constexpr int kLeastPixels = 20;
constexpr int kMostIterations = 15;
constexpr double kSettled_px = 2e-4;

// x, y of the crossing; angles of both edges' normals; logarithms of their blur; mean level, half contrast; shading.
constexpr int kUnknowns = 10;
using Unknowns = Eigen::Matrix<double, kUnknowns, 1>;
using Normal = Eigen::Matrix<double, kUnknowns, kUnknowns>;
enum { kX, kY, kAngle, kBlur = kAngle + 2, kMean = kBlur + 2, kContrast, kShade };

struct Pixel {
  double x = 0.0, y = 0.0;  // from the place to begin with
  double grey = 0.0;
};

// An edge's profile from -1 to 1: a logistic step, averaged over a pixel.
struct Step {
  double value = 0.0;
  double by_distance = 0.0;
  double by_log_blur = 0.0;
};

Step step_at(double distance, double blur) {
  constexpr double kFarOff = 18.0;  // in units of the blur: there it is flat
  const double above = distance + kHalfPixel, below = distance - kHalfPixel;
  if (below > kFarOff * blur) return {1.0, 0.0, 0.0};
  if (above < -kFarOff * blur) return {-1.0, 0.0, 0.0};
  const auto tanh_and_log_cosh = [&](double at, double& log_cosh) {
    const double x = std::abs(at) / blur;
    const double e = std::exp(-2.0 * x);
    log_cosh = x + std::log1p(e) - M_LN2;
    return std::copysign((1.0 - e) / (1.0 + e), at);
  };
  double log_above = 0.0, log_below = 0.0;
  const double tanh_above = tanh_and_log_cosh(above, log_above);
  const double tanh_below = tanh_and_log_cosh(below, log_below);
  Step out;
  out.value = blur * (log_above - log_below) / (2.0 * kHalfPixel);
  out.by_distance = (tanh_above - tanh_below) / (2.0 * kHalfPixel);
  out.by_log_blur = out.value - (above * tanh_above - below * tanh_below) / (2.0 * kHalfPixel);
  return out;
}

class CornerFit {
 public:
  CornerFit(std::vector<Pixel> pixels, const CornerWindow& window)
      : pixels_(std::move(pixels)), curvature_(window.curvature) {
    state_.setZero();
    for (int edge = 0; edge < 2; ++edge) {
      const Eigen::Vector2d along = window.px_of_board.col(edge);
      state_(kAngle + edge) = std::atan2(along.x(), -along.y());
      state_(kBlur + edge) = std::log(kFirstBlur_px);
    }
    find_levels();
  }

  // Levenberg-Marquardt; the place of the crossing from where it began.
  std::optional<Eigen::Vector2d> run() {
    double damping = 1e-3;
    Normal H;
    Unknowns g;
    double cost = build(state_, &H, &g);
    for (int i = 0; i < kMostIterations; ++i) {
      Normal damped = H;
      damped.diagonal() *= 1.0 + damping;
      damped.diagonal().array() += 1e-9;
      const Unknowns move = damped.ldlt().solve(g);
      const Unknowns next = bounded(state_ + move);
      Normal next_H;
      Unknowns next_g;
      const double next_cost = build(next, &next_H, &next_g);
      if (!(next_cost < cost)) {
        damping *= 10.0;
        if (move.head<2>().norm() < kSettled_px || damping > 1e6) break;
        continue;
      }
      state_ = next;
      cost = next_cost;
      H = next_H;
      g = next_g;
      damping = std::max(1e-6, 0.1 * damping);
      if (move.head<2>().norm() < kSettled_px) break;
    }
    return judged(cost);
  }

 private:
  static Unknowns bounded(Unknowns s) {
    for (int edge = 0; edge < 2; ++edge) {
      s(kBlur + edge) = std::clamp(s(kBlur + edge), std::log(kLeastBlur_px), std::log(kWidestBlur_px));
    }
    return s;
  }

  std::optional<Eigen::Vector2d> judged(double cost) const {
    const Eigen::Vector2d moved = state_.head<2>();
    const double half_contrast = std::abs(state_(kContrast));
    const double left_over = std::sqrt(cost / static_cast<double>(pixels_.size()));
    if (!state_.allFinite() || moved.norm() > kMostMoved_px) return std::nullopt;
    if (half_contrast < kLeastHalfContrast || left_over > kMostLeftOver * half_contrast) return std::nullopt;
    return moved;
  }

  struct Edge {
    Eigen::Vector2d by_place;
    double by_angle = 0.0;
    Step step;
  };
  Edge edge_at(const Unknowns& s, int edge, const Eigen::Vector2d& from) const {
    const double c = std::cos(s(kAngle + edge)), si = std::sin(s(kAngle + edge));
    const Eigen::Vector2d normal(c, si), along(-si, c);
    const double t = along.dot(from), n = normal.dot(from), bend = curvature_[static_cast<std::size_t>(edge)];
    Edge out;
    out.step = step_at(n - 0.5 * bend * t * t, std::exp(s(kBlur + edge)));
    out.by_place = out.step.by_distance * (bend * t * along - normal);
    out.by_angle = out.step.by_distance * (t + bend * t * n);
    return out;
  }

  // Sum of squared residuals, with the normal equations.
  double build(const Unknowns& s, Normal* H, Unknowns* g) const {
    double cost = 0.0;
    H->setZero();
    g->setZero();
    Unknowns by;
    for (const Pixel& p : pixels_) {
      const Eigen::Vector2d at(p.x, p.y), from = at - s.head<2>();
      const Edge a = edge_at(s, 0, from), b = edge_at(s, 1, from);
      const double light = 1.0 + s(kShade) * p.x + s(kShade + 1) * p.y;
      const double pattern = a.step.value * b.step.value;
      const double level = s(kMean) + s(kContrast) * pattern;
      const double error = p.grey - light * level;
      const double contrast = light * s(kContrast);
      by.head<2>() = contrast * (b.step.value * a.by_place + a.step.value * b.by_place);
      by(kAngle) = contrast * b.step.value * a.by_angle;
      by(kAngle + 1) = contrast * a.step.value * b.by_angle;
      by(kBlur) = contrast * b.step.value * a.step.by_log_blur;
      by(kBlur + 1) = contrast * a.step.value * b.step.by_log_blur;
      by(kMean) = light;
      by(kContrast) = light * pattern;
      by.tail<2>() = level * at;
      H->noalias() += by * by.transpose();
      g->noalias() += error * by;
      cost += error * error;
    }
    return cost;
  }

  // Mean and contrast by least squares; the sign says which quarters are bright.
  void find_levels() {
    double sum = 0.0, squared = 0.0, grey = 0.0, product = 0.0;
    for (const Pixel& p : pixels_) {
      const Eigen::Vector2d from(p.x, p.y);
      const double pattern = edge_at(state_, 0, from).step.value * edge_at(state_, 1, from).step.value;
      sum += pattern;
      squared += pattern * pattern;
      grey += p.grey;
      product += pattern * p.grey;
    }
    const auto n = static_cast<double>(pixels_.size());
    const double spread = n * squared - sum * sum;
    state_(kContrast) = spread > 0.0 ? (n * product - sum * grey) / spread : 0.0;
    state_(kMean) = (grey - state_(kContrast) * sum) / n;
  }

  std::vector<Pixel> pixels_;
  std::array<double, 2> curvature_;
  Unknowns state_;
};

// Those along both edges as far as they reach, and no farther beside them than is free.
std::vector<Pixel> pixels_of(ImageView<const std::uint8_t> image, const Eigen::Vector2d& start,
                             const CornerWindow& window) {
  const Eigen::Vector2d unit_px(window.px_of_board.col(0).norm(), window.px_of_board.col(1).norm());
  const Eigen::Vector2d reach = (kMostReach_px * unit_px.cwiseInverse()).cwiseMin(window.reach);
  const Eigen::Matrix2d to_board = window.px_of_board.inverse();
  // Beside the first edge is the second axis.
  const Eigen::Vector2d free = ((window.free * unit_px).array() - kBlurredInto_px).min(kMostFree_px);
  if (!to_board.allFinite() || reach.cwiseProduct(unit_px).minCoeff() < kLeastReach_px) return {};
  if (free.minCoeff() < kLeastFree_px) return {};
  const Eigen::Vector2d half = window.px_of_board.cwiseAbs() * reach;
  const int x0 = static_cast<int>(std::ceil(start.x() - half.x())), x1 = static_cast<int>(start.x() + half.x());
  const int y0 = static_cast<int>(std::ceil(start.y() - half.y())), y1 = static_cast<int>(start.y() + half.y());
  std::vector<Pixel> out;
  for (int y = std::max(y0, 0); y <= std::min(y1, image.height - 1); ++y) {
    for (int x = std::max(x0, 0); x <= std::min(x1, image.width - 1); ++x) {
      const Eigen::Vector2d from(x - start.x(), y - start.y());
      const Eigen::Vector2d on_board = (to_board * from).cwiseAbs();
      if ((on_board.array() > reach.array()).any() || (on_board.cwiseProduct(unit_px).array() > free.array()).all())
        continue;
      out.push_back({from.x(), from.y(), static_cast<double>(image(x, y))});
    }
  }
  return out;
}

}  // namespace

std::optional<Eigen::Vector2d> fit_corner(ImageView<const std::uint8_t> image, const Eigen::Vector2d& start,
                                          const CornerWindow& window) {
  std::vector<Pixel> pixels = pixels_of(image, start, window);
  if (static_cast<int>(pixels.size()) < kLeastPixels) return std::nullopt;
  const auto moved = CornerFit(std::move(pixels), window).run();
  return moved ? std::optional<Eigen::Vector2d>(start + *moved) : std::nullopt;
}

}  // namespace cliquevo::tools
