// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/board_calibration/adjustment.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Cholesky>

namespace cliquevo::calibration {

namespace {

using SharedVector = Eigen::Matrix<double, kShared, 1>;
using SharedMatrix = Eigen::Matrix<double, kShared, kShared>;
using SharedByPose = Eigen::Matrix<double, kShared, 6>;

constexpr double kHuberSigmas = 2.5;
constexpr double kNormalMedian = 1.1774;  // of the length of a two-dimensional normal vector, in sigmas
constexpr double kLeastSigma_px = 1e-4;   // exact corners
// What a fit of a corner's edges is off by beyond its noise (0.003 to 0.02 px in noise-free pictures), and what all
// views may share: noise alone would promise too much.
constexpr double kShared_px = 0.01;
constexpr double kUnseen_px = 1e3;      // residual of a corner that the model does not reach: the step is refused
constexpr double kRationalSigma = 1.0;  // expected size of the coefficients of a rational lens
constexpr double kFirstDamping = 1e-3;
constexpr double kMostDamping = 1e12;
constexpr double kLeastGain = 1e-10;  // of the cost: converged

struct Corner {
  Eigen::Vector2d error;  // seen - projected
  Eigen::Matrix<double, 2, kShared> by_shared;
  Eigen::Matrix<double, 2, 6> by_pose;
  bool seen = false;
};

Eigen::Matrix<double, 3, 6> by_left_step(const Eigen::Vector3d& p) {
  Eigen::Matrix<double, 3, 6> J;
  J.leftCols<3>().setIdentity();
  J.rightCols<3>() = -skew(p);
  return J;
}

Corner linearize(const Board& board, const Rig& rig, const RigidTransform& T_left_board, const SeenCorner& seen,
                 Side side) {
  const BentCorner board_corner = bent_corner(board, seen.id, rig.bend_m);
  const Eigen::Vector3d in_left = T_left_board * board_corner.at;
  const bool right = side == Side::right;
  const Eigen::Vector3d in_camera = right ? rig.T_right_left * in_left : in_left;
  const Projection p = project_with_derivatives(*rig.model, rig.lens(side), in_camera);
  Corner out;
  out.seen = p.seen;
  out.error = p.seen ? Eigen::Vector2d(seen.px - p.px) : Eigen::Vector2d::Constant(kUnseen_px);
  out.by_shared.setZero();
  const Eigen::Matrix<double, 2, 3> by_left =
      right ? Eigen::Matrix<double, 2, 3>(p.by_point * rig.T_right_left.R) : p.by_point;
  out.by_pose = by_left * by_left_step(in_left);
  out.by_shared.middleCols<kMostLens>(right ? kFirstOfRight : 0) = p.by_lens;
  if (right) out.by_shared.middleCols<6>(kFirstOfPose) = p.by_point * by_left_step(in_camera);
  out.by_shared.rightCols<2>() = by_left * T_left_board.R.col(2) * board_corner.height_by_bend;
  return out;
}

double huber_cost(double length, double bound) {
  return length <= bound ? length * length : bound * (2.0 * length - bound);
}

class Adjustment {
 public:
  Adjustment(const Board& board, const std::vector<View>& views, const AdjustmentOptions& options)
      : board_(board), views_(views), options_(options), poses_(views.size()) {
    const Eigen::Vector2d half = board.half_extent();
    bend_weight_ = (options.bend_sigma * half).cwiseAbs2().cwiseMax(1e-18).cwiseInverse();
  }

  Adjusted run(Adjusted state) {
    expect_lens(*state.rig.model);
    double damping = kFirstDamping;
    learn_scale(state);
    double cost = this->cost(state);
    for (state.iterations = 0; state.iterations < options_.most_iterations; ++state.iterations) {
      build(state);
      bool better = false;
      while (!better && damping < kMostDamping) {
        Adjusted next = stepped(state, damping);
        const double next_cost = this->cost(next);
        better = next_cost < cost;
        if (!better) {
          state.converged = true;  // as far as numbers go
          damping *= 10.0;
          continue;
        }
        state.converged = cost - next_cost <= kLeastGain * cost;
        next.converged = state.converged;
        next.iterations = state.iterations;
        state = std::move(next);
        cost = next_cost;
        damping = std::max(1e-9, 0.1 * damping);
      }
      if (!better || state.converged) break;
      if (options_.robust && state.iterations % 5 == 4) {
        learn_scale(state);
        cost = this->cost(state);
      }
    }
    finish(state);
    return state;
  }

 private:
  template <typename F>
  void each_corner(const Adjusted& state, F&& use) const {
    for (std::size_t v = 0; v < views_.size(); ++v) {
      for (const Side side : {Side::left, Side::right}) {
        for (const SeenCorner& seen : views_[v].of(side)) use(v, side, seen, state.T_left_board[v]);
      }
    }
  }

  Eigen::Vector2d error_of(const Adjusted& state, Side side, const SeenCorner& seen, const RigidTransform& T) const {
    const Eigen::Vector3d in_left = T * bent_corner(board_, seen.id, state.rig.bend_m).at;
    const auto px = project(*state.rig.model, state.rig.lens(side),
                            side == Side::right ? Eigen::Vector3d(state.rig.T_right_left * in_left) : in_left);
    return px ? Eigen::Vector2d(seen.px - *px) : Eigen::Vector2d::Constant(kUnseen_px);
  }

  // Of a quotient of polynomials many fit alike: the one with small coefficients is wanted.
  void expect_lens(const LensModel& model) {
    lens_weight_.setZero();
    if (model.distortion != Distortion::rational) return;
    for (int i = kFocalAndCentre; i < model.size(); ++i) {
      if (model.parameter_name(i)[0] == 'k') lens_weight_(i) = 1.0 / (kRationalSigma * kRationalSigma);
    }
  }

  // Robust scale of the errors; the bound of Huber's cost is a multiple of it, and the prior on the bend, which is in
  // units of the corners' noise, needs it too.
  void learn_scale(const Adjusted& state) {
    std::vector<double> lengths;
    each_corner(state, [&](std::size_t, Side side, const SeenCorner& seen, const RigidTransform& T) {
      lengths.push_back(error_of(state, side, seen, T).norm());
    });
    if (!lengths.empty()) {
      const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
      std::nth_element(lengths.begin(), middle, lengths.end());
      scale_px_ = std::max(kLeastSigma_px, *middle / kNormalMedian);
    }
    bound_ = options_.robust ? kHuberSigmas * scale_px_ : std::numeric_limits<double>::infinity();
  }

  // Priors are in units of the corners' noise.
  double prior_scale() const { return scale_px_ * scale_px_; }

  double cost(const Adjusted& state) const {
    double sum = state.rig.bend_m.cwiseAbs2().dot(bend_weight_);
    for (const Side side : {Side::left, Side::right}) sum += state.rig.lens(side).cwiseAbs2().dot(lens_weight_);
    sum *= prior_scale();
    each_corner(state, [&](std::size_t, Side side, const SeenCorner& seen, const RigidTransform& T) {
      sum += huber_cost(error_of(state, side, seen, T).norm(), bound_);
    });
    return std::isfinite(sum) ? sum : std::numeric_limits<double>::infinity();
  }

  void build(const Adjusted& state) {
    shared_.setZero();
    shared_gradient_.setZero();
    for (Pose& pose : poses_) pose = {};
    each_corner(state, [&](std::size_t v, Side side, const SeenCorner& seen, const RigidTransform& T) {
      Corner c = linearize(board_, state.rig, T, seen, side);
      if (!c.seen) return;
      keep_estimated(c.by_shared);
      const double length = c.error.norm();
      const double weight = length <= bound_ ? 1.0 : bound_ / length;
      Pose& pose = poses_[v];
      shared_.noalias() += weight * c.by_shared.transpose() * c.by_shared;
      shared_gradient_.noalias() += weight * c.by_shared.transpose() * c.error;
      pose.own.noalias() += weight * c.by_pose.transpose() * c.by_pose;
      pose.gradient.noalias() += weight * c.by_pose.transpose() * c.error;
      pose.shared.noalias() += weight * c.by_shared.transpose() * c.by_pose;
    });
    for (int i = 0; i < 2; ++i) {
      add_prior(kFirstOfBend + i, bend_weight_(i), state.rig.bend_m(i));
    }
    for (int i = 0; i < kMostLens; ++i) {
      add_prior(i, lens_weight_(i), state.rig.left(i));
      add_prior(kFirstOfRight + i, lens_weight_(i), state.rig.right(i));
    }
  }

  void add_prior(int at, double weight, double value) {
    if (!options_.estimated[static_cast<std::size_t>(at)]) return;
    shared_(at, at) += prior_scale() * weight;
    shared_gradient_(at) -= prior_scale() * weight * value;
  }

  // Columns of what is not estimated are 0; with square pixels fx and fy are one.
  void keep_estimated(Eigen::Matrix<double, 2, kShared>& by_shared) const {
    if (options_.square_pixels) {
      for (const int fx : {0, kFirstOfRight}) by_shared.col(fx) += by_shared.col(fx + 1);
    }
    for (int i = 0; i < kShared; ++i) {
      if (!options_.estimated[static_cast<std::size_t>(i)]) by_shared.col(i).setZero();
    }
  }

  // Shared unknowns alone, the poses eliminated. Unknowns that are not estimated get a 1 on the diagonal.
  SharedMatrix reduced(double damping, SharedVector* gradient) const {
    SharedMatrix H = shared_;
    H.diagonal() += damping * shared_.diagonal();
    for (int i = 0; i < kShared; ++i) {
      if (!options_.estimated[static_cast<std::size_t>(i)]) H(i, i) = 1.0;
    }
    SharedVector g = shared_gradient_;
    for (const Pose& pose : poses_) {
      const SharedByPose W = pose.shared * inverse_of(pose, damping);
      H.noalias() -= W * pose.shared.transpose();
      g.noalias() -= W * pose.gradient;
    }
    if (gradient != nullptr) *gradient = g;
    return H;
  }

  struct Pose {
    Matrix6d own = Matrix6d::Zero();
    Vector6d gradient = Vector6d::Zero();
    SharedByPose shared = SharedByPose::Zero();
  };

  static Matrix6d inverse_of(const Pose& pose, double damping) {
    Matrix6d H = pose.own;
    H.diagonal() += damping * pose.own.diagonal();
    H.diagonal().array() += 1e-12;
    return H.ldlt().solve(Matrix6d::Identity());
  }

  Adjusted stepped(const Adjusted& state, double damping) const {
    SharedVector g;
    const SharedMatrix H = reduced(damping, &g);
    SharedVector step = H.ldlt().solve(g);
    Adjusted next = state;
    for (std::size_t v = 0; v < poses_.size(); ++v) {
      const Vector6d pose_step =
          inverse_of(poses_[v], damping) * (poses_[v].gradient - poses_[v].shared.transpose() * step);
      next.T_left_board[v] = perturb_left(state.T_left_board[v], pose_step).normalized();
    }
    copy_square(step);
    next.rig = state.rig.moved(step);
    return next;
  }

  void copy_square(SharedVector& step) const {
    if (!options_.square_pixels) return;
    for (const int fx : {0, kFirstOfRight}) step(fx + 1) = step(fx);
  }

  void finish(Adjusted& state) {
    double sum = 0.0;
    double coordinates = 0.0;
    double unknowns = 0.0;
    each_corner(state, [&](std::size_t, Side side, const SeenCorner& seen, const RigidTransform& T) {
      const double length = error_of(state, side, seen, T).norm();
      sum += huber_cost(length, bound_);
      coordinates += 2.0;
    });
    for (const bool estimated : options_.estimated) unknowns += estimated ? 1.0 : 0.0;
    unknowns += 6.0 * static_cast<double>(views_.size());
    state.sigma_px = std::sqrt(sum / std::max(1.0, coordinates - unknowns));
    scale_px_ = std::max(kLeastSigma_px, state.sigma_px);
    build(state);
    const SharedMatrix H = reduced(0.0, nullptr);
    const double variance = state.sigma_px * state.sigma_px + kShared_px * kShared_px;
    state.covariance = variance * H.ldlt().solve(SharedMatrix::Identity());
    for (int i = 0; i < kShared; ++i) {
      if (options_.estimated[static_cast<std::size_t>(i)]) continue;
      state.covariance.row(i).setZero();
      state.covariance.col(i).setZero();
    }
    if (!options_.square_pixels) return;
    for (const int fx : {0, kFirstOfRight}) {
      state.covariance.row(fx + 1) = state.covariance.row(fx);
      state.covariance.col(fx + 1) = state.covariance.col(fx);
    }
  }

  const Board& board_;
  const std::vector<View>& views_;
  AdjustmentOptions options_;
  Eigen::Vector2d bend_weight_;  // 1/m^2
  LensVector lens_weight_ = LensVector::Zero();
  double bound_ = 0.0;     // px
  double scale_px_ = 1.0;  // of a coordinate's error
  SharedMatrix shared_;
  SharedVector shared_gradient_;
  std::vector<Pose> poses_;
};

}  // namespace

Adjusted adjust(const Board& board, const std::vector<View>& views, const Rig& start,
                const std::vector<RigidTransform>& T_left_board, const AdjustmentOptions& options) {
  Adjusted state;
  state.rig = start;
  state.T_left_board = T_left_board;
  return Adjustment(board, views, options).run(std::move(state));
}

std::vector<Eigen::Vector2d> residuals(const Board& board, const Rig& rig, const RigidTransform& T_left_board,
                                       const View& view, Side side) {
  std::vector<Eigen::Vector2d> out;
  for (const SeenCorner& seen : view.of(side)) {
    const Eigen::Vector3d in_left = T_left_board * bent_corner(board, seen.id, rig.bend_m).at;
    const auto px = project(*rig.model, rig.lens(side),
                            side == Side::right ? Eigen::Vector3d(rig.T_right_left * in_left) : in_left);
    out.push_back(px ? Eigen::Vector2d(seen.px - *px)
                     : Eigen::Vector2d::Constant(std::numeric_limits<double>::quiet_NaN()));
  }
  return out;
}

}  // namespace cliquevo::calibration
