// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/estimator.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/vo/validation.h"

namespace cliquevo::vo {

namespace {

constexpr double kGoodShare = 0.7;  // of a clique's members that its motion should keep
// The refined solution's covariance is scaled by what its residuals show of the real noise, which the loose sigmas of
// the weights overstate, but not below a floor (what is common to all features shows in no residual), and by a factor
// that makes the normalised error right (NEES 6) on the simulator's wheeled and walking courses.
constexpr double kLeastVariance = 0.05;
constexpr double kVarianceFactor = 1.25;
constexpr double kVarianceFactorOfTwo = 0.87;  // beside a key frame, where the weights understate the previous frame
// Patches that overlap err alike: times the share of the picture that the inliers' patches would cover side by side
// (normalised error squared at 256, 384, 512 and 768 px of width, without it 7.9, 6.0, 5.3 and 3.6).
constexpr double kOverlapVariance = 1.4;
// Errors that neighbours share (of the calibration, of a surface) do not average out where all inliers come from one
// part of the picture: below this share of its cells the covariance grows with the square of what is missing, and the
// disparities must fit the better, as behind an eye that hangs; but no better than this share of the usual bound.
constexpr double kFullCoverage = 0.5;
constexpr double kLeastCoverage = 0.05;
constexpr double kStrictest = 0.5;
constexpr double kLooser[] = {16.0, 4.0, 1.0};  // times the sigmas of matches, of a guided second attempt
constexpr int kAttempts = 3;
constexpr double kEvenLight = 15.0;  // grey levels by which light may change unevenly before it counts
// Ground that was seen to run, and a thing that moves before the world, may show it less the next time, over a longer
// way and with fewer points.
constexpr double kWary = 0.5;
constexpr double kWaryInliers = 0.25;  // share of the reference's features that must be found then
constexpr std::size_t kMostOthers = 8;
constexpr std::size_t kPilots = 80;
constexpr int kLeastPilots = 30;
constexpr double kEnough = 1.15;  // of max_features: so many observations of two references tell what more would

}  // namespace

Estimator::Estimator(const StereoModel& model, const VoParams& params)
    : model_(model),
      params_(params),
      matcher_(params.max_features),
      clique_finder_(model, params),
      solver_(model, params),
      tracker_(model, params),
      support_(model),
      other_finder_(params),
      others_(kMostOthers, static_cast<std::size_t>(params.max_features)) {
  const std::size_t n = static_cast<std::size_t>(params.max_features);
  matches_.reserve(n);
  pairs_.reserve(n);
  clique_.reserve(n);
  observations_.reserve(2 * n);
  references_.reserve(2);
  changes_.reserve(2 * n);
}

// A2' to A5 as in the paper: scores, co-occurring minima, clique, closed-form start, two-way minimisation.
bool Estimator::first_motion(const Frame& reference, const Frame& current, const RigidTransform& predicted,
                             Comparison& out, StepTimes& times) {
  matcher_.match(reference.descriptors, current.descriptors, matches_);
  times.scores_ns += matcher_.scores_ns();
  times.matches_ns += matcher_.minima_ns();
  out.matches = static_cast<int>(matches_.size());

  const std::int64_t clique_start_ns = monotonic_ns();
  pairs_.clear();
  for (const Match& m : matches_) {
    pairs_.push_back({reference.features[static_cast<std::size_t>(m.a)].point,
                      current.features[static_cast<std::size_t>(m.b)].point});
  }
  clique_finder_.find(pairs_, clique_);
  out.clique = static_cast<int>(clique_.size());
  const std::int64_t motion_start_ns = monotonic_ns();
  times.clique_ns += motion_start_ns - clique_start_ns;
  references_.assign(1, RigidTransform{});
  RigidTransform T_ref_cur;
  if (out.clique >= params_.min_inliers && align_points(pairs_, clique_, T_ref_cur)) {
    observe(reference, current, clique_);
    // Where the motion is refined afterwards, a start is all that is needed.
    out.motion = params_.refine ? solver_.solve(observations_, references_, T_ref_cur, params_.match_sigma_px,
                                                params_.match_disparity_sigma_px, Precision::rough)
                                : solver_.solve_tightening(observations_, references_, T_ref_cur,
                                                           params_.match_sigma_px, params_.match_disparity_sigma_px);
    // Far false matches are compatible with nearly everything and can pull the closed form away: then the motion is
    // looked for from the predicted one and from rest, and what most members agree on is taken.
    for (const RigidTransform& start : {predicted, RigidTransform{}}) {
      if (out.motion.converged && out.motion.inliers >= kGoodShare * out.clique) break;
      observe(reference, current, clique_);
      const Motion other =
          solver_.solve(observations_, references_, start, params_.match_sigma_px, params_.match_disparity_sigma_px);
      if (other.converged && other.inliers > out.motion.inliers) out.motion = other;
    }
  }
  const auto found = [&] { return out.motion.converged && out.motion.inliers >= params_.min_inliers; };
  for (const RigidTransform& start : {predicted, RigidTransform{}}) {
    if (found() || !params_.refine || out.matches < params_.min_inliers) break;
    out.motion = guided_motion(reference, current, start);
  }
  times.motion_ns += monotonic_ns() - motion_start_ns;
  return found();
}

// A second attempt, without a clique: what the matches agree on loosely, and then ever more closely, near a guess.
Motion Estimator::guided_motion(const Frame& reference, const Frame& current, const RigidTransform& start) {
  observations_.clear();
  for (const Match& m : matches_) observations_.push_back(observe_match(reference, current, m));
  Motion motion;
  motion.T_prev_cur = start;
  for (const double looser : kLooser) {
    for (Observation& o : observations_) o.inlier = true;
    motion = solver_.solve(observations_, references_, motion.T_prev_cur, looser * params_.match_sigma_px,
                           looser * params_.match_disparity_sigma_px);
    if (!motion.converged) break;
  }
  return motion;
}

void Estimator::observe(const Frame& reference, const Frame& current, const std::vector<int>& members) {
  observations_.clear();
  for (const int i : members) {
    observations_.push_back(observe_match(reference, current, matches_[static_cast<std::size_t>(i)]));
  }
}

// A second motion that a good share as many matches support: which of the two is the world's?
bool Estimator::rivalled(int explained) const {
  const int enough = std::max(params_.min_inliers, static_cast<int>(std::ceil(params_.rival_share * explained)));
  for (std::size_t i = 0; i < others_.size(); ++i) {
    if (others_[i].clique >= enough && others_[i].motion.inliers >= enough) return true;
  }
  return false;
}

// Looks for the features of the references where the first motion puts them, and solves again for what is found.
void Estimator::refine(const Frame& reference, const Frame* key, const Frame& current, const SelfCheck& check,
                       Comparison& out) {
  observations_.clear();
  references_.assign(1, RigidTransform{});
  // The first features, which are spread over the picture, tell where to look for the others.
  tracker_.track(reference, current, out.motion.T_prev_cur, 0, 0, kPilots, check, observations_);
  const Motion pilot = solver_.solve(observations_, references_, out.motion.T_prev_cur, params_.sigma_px,
                                     params_.disparity_sigma_px, Precision::rough);
  if (pilot.converged && pilot.inliers >= kLeastPilots) out.motion = pilot;
  for (Observation& o : observations_) o.inlier = true;
  constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
  const auto of_pilots = static_cast<std::ptrdiff_t>(observations_.size());
  std::ptrdiff_t of_key = 0;
  std::size_t last = kAll;
  const bool beside_key = key != nullptr && key != &reference;
  if (beside_key) {
    // The key frame's tell more; the previous frame's make up the number.
    const RigidTransform T_ref_key = reference.T_world_camera.inverse() * key->T_world_camera;
    references_.push_back(T_ref_key);
    tracker_.track(*key, current, T_ref_key.inverse() * out.motion.T_prev_cur, 1, 0, kAll, check, observations_);
    of_key = static_cast<std::ptrdiff_t>(observations_.size()) - of_pilots;
    const auto enough = static_cast<std::size_t>(kEnough * params_.max_features);
    last = kPilots + enough - std::min(enough, observations_.size());
  }
  tracker_.track(reference, current, out.motion.T_prev_cur, 0, kPilots, last, check, observations_);
  std::rotate(observations_.begin() + of_pilots, observations_.begin() + of_pilots + of_key, observations_.end());
  out.motion =
      solver_.solve(observations_, references_, out.motion.T_prev_cur, params_.sigma_px, params_.disparity_sigma_px);
  const Frame& kept = beside_key ? *key : reference;
  const int of_kept = beside_key ? 1 : 0;
  const auto found = std::count_if(observations_.begin(), observations_.end(),
                                   [of_kept](const Observation& o) { return o.inlier && o.reference == of_kept; });
  out.key_overlap = static_cast<double>(found) / static_cast<double>(std::max<std::size_t>(1, kept.features.size()));
  const double residual =
      out.motion.error_px / params_.sigma_px;  // two of the three components count: disparity is loose
  const double factor = beside_key ? kVarianceFactorOfTwo : kVarianceFactor;
  out.motion.covariance *= factor * std::max(kLeastVariance, 0.5 * residual * residual);
  const double side_px = 2.0 * params_.refine_radius_px + 3.0;
  const double crowded = out.motion.inliers * side_px * side_px / (static_cast<double>(model_.width) * model_.height);
  out.motion.covariance *= 1.0 + kOverlapVariance * crowded;
}

// A5 and A6 from a first motion on, again for as long as what was found is not enough but finds more.
void Estimator::settle(const Frame& reference, const Frame* key, const Frame& current, const SelfCheck& check,
                       Comparison& out, double& disparity_px) {
  for (int attempt = 0, inliers = 0; attempt < kAttempts; ++attempt) {
    if (params_.refine) {
      refine(reference, key, current, check, out);
      disparity_px = disparity_error_px(observations_, references_, out.motion.T_prev_cur, model_);
    }
    out.eigenvalue_ratio = spread_ratio(observations_);
    out.status = validate(out.motion, out.eigenvalue_ratio, disparity_px, params_);
    if (out.status == Status::valid || !params_.refine || out.motion.inliers <= inliers) break;
    inliers = out.motion.inliers;
  }
}

Comparison Estimator::compare(const Frame& reference, const Frame* key, const Frame& current,
                              ImageView<const std::int16_t> disparity, std::span<const RigidTransform> predicted,
                              const SelfCheck& check, bool wary, StepTimes& times) {
  Comparison out;
  others_.clear();
  const bool started = first_motion(reference, current, predicted.front(), out, times);
  const std::int64_t start_ns = monotonic_ns();
  double disparity_px = 0.0;
  if (started) {
    settle(reference, key, current, check, out, disparity_px);
  } else {
    // Of fast driving's matches too few may be true, but the features may be where a predicted motion has them.
    out.status = Status::too_few_features;
    if (!params_.refine || out.matches < params_.min_inliers) return out;
    for (const RigidTransform& start : predicted) {
      if (start.t.isZero()) continue;
      out.motion = {};
      out.motion.T_prev_cur = start;
      settle(reference, key, current, check, out, disparity_px);
      if (out.motion.inliers < kLeastPilots) out.status = Status::too_few_features;
      if (out.status == Status::valid) break;
    }
  }
  if (out.status == Status::valid && params_.refine) {
    out.unsteadiness_px = out.motion.error_px * excess_change(observations_, changes_);
    if (out.unsteadiness_px > 0.0) out.unsteadiness_px *= surprise(out.motion);
    const CellVotes votes = support_.count(reference, current, disparity, out.motion.T_prev_cur, check, observations_);
    out.contradiction = votes.share();
    const double covered = std::clamp(votes.coverage(), kLeastCoverage, kFullCoverage) / kFullCoverage;
    out.motion.covariance /= covered * covered;
    const double light = change_of_light(observations_, changes_) / kEvenLight;
    out.motion.covariance *= 1.0 + light * light;
    if (disparity_px > std::max(covered, kStrictest) * params_.max_reprojection_error_px) {
      out.status = Status::reprojection_error;
    }
    const double bound = wary ? kWary : 1.0;
    out.contradicted = out.contradiction > params_.max_contradiction;
    out.unsteady = std::abs(out.unsteadiness_px) > bound * params_.max_unsteadiness_px;
    const bool weak = out.motion.inliers < kWaryInliers * static_cast<double>(reference.features.size());
    if (out.contradiction > bound * params_.max_contradiction || out.unsteady || (wary && weak)) {
      out.status = Status::ambiguous;
    }
  }
  if (out.status == Status::valid || out.status == Status::ambiguous) {
    const int explained =
        other_finder_.find(reference, current, matches_, pairs_, out.motion, clique_finder_, solver_, others_);
    if (rivalled(explained)) out.status = Status::ambiguous;
  }
  times.motion_ns += monotonic_ns() - start_ns;
  return out;
}

}  // namespace cliquevo::vo
