// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/other_motions.h"

#include <algorithm>

#include <Eigen/Cholesky>

namespace cliquevo::vo {

namespace {

constexpr double kApartSigmas = 5.0;  // two motions farther apart are two

bool apart(const Motion& a, const Motion& b) {
  const Vector6d difference = left_difference(a.T_prev_cur, b.T_prev_cur);
  const Matrix6d covariance = a.covariance + b.covariance;
  return difference.dot(covariance.ldlt().solve(difference)) > kApartSigmas * kApartSigmas;
}

}  // namespace

OtherMotions::OtherMotions(std::size_t most, std::size_t max_features) : items_(most) {
  for (OtherMotion& item : items_) {
    item.observations.reserve(max_features);
    item.matches.reserve(max_features);
  }
}

Observation observe_match(const Frame& reference, const Frame& current, const Match& match) {
  const Feature& a = reference.features[static_cast<std::size_t>(match.a)];
  const Feature& b = current.features[static_cast<std::size_t>(match.b)];
  Observation o;
  o.uvd_ref = {static_cast<double>(a.x), static_cast<double>(a.y), a.disparity_px};
  o.uvd_cur = {static_cast<double>(b.x), static_cast<double>(b.y), b.disparity_px};
  o.feature = match.a;
  return o;
}

OtherMotionFinder::OtherMotionFinder(const VoParams& params) : params_(params), references_(1) {
  const std::size_t n = static_cast<std::size_t>(params.max_features);
  observations_.reserve(n);
  unexplained_.reserve(n);
  clique_.reserve(n);
  left_.reserve(n);
}

int OtherMotionFinder::find(const Frame& reference, const Frame& current, const std::vector<Match>& matches,
                            const std::vector<PointPair>& pairs, const Motion& first, CliqueFinder& clique_finder,
                            MotionSolver& solver, OtherMotions& others) {
  others.clear();
  observations_.clear();
  for (const Match& m : matches) observations_.push_back(observe_match(reference, current, m));
  solver.judge(observations_, references_, first.T_prev_cur, first.shift_px,
               {params_.match_sigma_px, params_.match_disparity_sigma_px});
  unexplained_.clear();
  for (std::size_t i = 0; i < observations_.size(); ++i) {
    if (!observations_[i].inlier) unexplained_.push_back(static_cast<int>(i));
  }
  const int explained = static_cast<int>(observations_.size() - unexplained_.size());
  const std::size_t least = static_cast<std::size_t>(params_.min_mover_points);
  while (unexplained_.size() >= least && !others.full()) {
    clique_finder.among(static_cast<int>(pairs.size()), unexplained_, clique_);
    if (clique_.size() < least) break;
    solve(reference, current, matches, pairs, first, solver, others);
    // Whatever became of it, the next one is looked for among the others.
    std::sort(clique_.begin(), clique_.end());
    left_.clear();
    std::set_difference(unexplained_.begin(), unexplained_.end(), clique_.begin(), clique_.end(),
                        std::back_inserter(left_));
    unexplained_.swap(left_);
  }
  return explained;
}

void OtherMotionFinder::solve(const Frame& reference, const Frame& current, const std::vector<Match>& matches,
                              const std::vector<PointPair>& pairs, const Motion& first, MotionSolver& solver,
                              OtherMotions& others) {
  RigidTransform start;
  if (!align_points(pairs, clique_, start)) return;
  observations_.clear();
  for (const int i : clique_) {
    observations_.push_back(observe_match(reference, current, matches[static_cast<std::size_t>(i)]));
  }
  const Motion motion =
      solver.solve(observations_, references_, start, {params_.match_sigma_px, params_.match_disparity_sigma_px});
  if (!motion.converged || motion.inliers < params_.min_mover_points || !apart(first, motion)) return;
  OtherMotion& other = others.add();
  other.motion = motion;
  other.clique = static_cast<int>(clique_.size());
  other.observations.clear();
  other.matches.clear();
  for (std::size_t i = 0; i < clique_.size(); ++i) {
    if (!observations_[i].inlier) continue;
    other.observations.push_back(observations_[i]);
    other.matches.push_back(matches[static_cast<std::size_t>(clique_[i])]);
  }
}

}  // namespace cliquevo::vo
