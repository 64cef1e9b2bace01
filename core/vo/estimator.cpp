// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/estimator.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/time.h"
#include "core/vo/sharpness.h"
#include "core/vo/uncertainty.h"

namespace cliquevo::vo {

namespace {

constexpr double kGoodShare = 0.7;              // of a clique's members that its motion should keep
constexpr double kLooser[] = {16.0, 4.0, 1.0};  // times the sigmas of matches, of a guided search
constexpr int kAttempts = 3;                    // to find more features from where those found so far put them
constexpr std::size_t kPilots = 80;             // features that show where to look for the others
constexpr int kLeastPilots = 30;
constexpr double kEnough = 1.15;       // of max_features: more observations of two references add nothing
constexpr double kFullCoverage = 0.5;  // of the picture's cells: inliers from so many are inliers from everywhere
constexpr std::size_t kMostOthers = 8;
constexpr double kMostTurn = 0.001;       // rad during a rolling shutter's readout, by vibration
constexpr double kManyContradict = 0.25;  // of the check's bound
constexpr double kMuchChange = 0.5;       // likewise, of running ground: worth knowing whether it is blur

// Of two attempts, the one to go by: a valid one, else the one that found more.
bool better(const Comparison& a, const Comparison& b) {
  const bool a_valid = a.status == Status::valid;
  const bool b_valid = b.status == Status::valid;
  if (a_valid != b_valid) return a_valid;
  return a.motion.inliers > b.motion.inliers || (a.motion.inliers == b.motion.inliers && a.matches > b.matches);
}

const Descriptors& fine(const Frame& frame) { return frame.descriptors; }
const Descriptors& coarse(const Frame& frame) { return frame.coarse_descriptors; }

}  // namespace

Estimator::Estimator(const StereoModel& model, const VoParams& params)
    : model_(model),
      params_(params),
      matcher_(params.max_features),
      clique_finder_(model, params),
      solver_(model, params),
      tracker_(model, params),
      consistency_(model),
      other_finder_(params),
      others_(kMostOthers, static_cast<std::size_t>(params.max_features)) {
  const std::size_t n = static_cast<std::size_t>(params.max_features);
  matches_.reserve(n);
  key_matches_.reserve(n);
  pairs_.reserve(n);
  clique_.reserve(n);
  observations_.reserve(2 * n);
  references_.reserve(2);
  scratch_.reserve(2 * n);
}

Comparison Estimator::compare(const FramePair& pair, StepTimes& times) {
  // Half resolution and larger patches follow where the usual ones find nothing: in blurred and in small pictures.
  constexpr Start kStarts[] = {{fine, PatchSize::usual}, {coarse, PatchSize::usual}, {coarse, PatchSize::large}};
  Comparison best;
  shift_sigma_px_ = pair.noise.shift_sigma_px();
  tracker_.set_noise(pair.noise.grey_levels());
  for (const Start& start : kStarts) {
    Comparison found;
    first_motion(pair, start, found, times);
    const std::int64_t start_ns = monotonic_ns();
    if (found.started) settle_and_judge(pair, start.patches, found);
    if (better(found, best)) best = found;
    times.motion_ns += monotonic_ns() - start_ns;
    if (best.status == Status::valid || !params_.refine) return best;
  }
  const std::int64_t start_ns = monotonic_ns();
  if (!best.started) predicted_motion(pair, best);
  times.motion_ns += monotonic_ns() - start_ns;
  return best;
}

void Estimator::settle_and_judge(const FramePair& pair, PatchSize patches, Comparison& out) {
  others_.clear();
  if (settle(pair, patches, out)) judge(pair, out);
  out.status = verdict(out.checks);
}

// A2' to A5 as in the paper: scores, co-occurring minima, clique, closed-form start, two-way minimisation. Where the
// clique gives no motion, the matches are searched without one, near the predicted motion and near rest.
void Estimator::first_motion(const FramePair& pair, const Start& start, Comparison& out, StepTimes& times) {
  match(pair, start, out, times);
  const std::int64_t start_ns = monotonic_ns();
  bool found = clique_motion(pair, out);
  for (const RigidTransform& from : {pair.predictions.front(), RigidTransform{}}) {
    if (found || !params_.refine || out.matches < params_.min_inliers) break;
    found = guided_motion(pair, from, out);
  }
  times.motion_ns += monotonic_ns() - start_ns;
  out.started = found;
  if (!found) out.checks[Check::inliers] = check_inliers(check_input(pair, {}), params_);
}

void Estimator::match(const FramePair& pair, const Start& start, Comparison& out, StepTimes& times) {
  matcher_.match(start.descriptors(pair.reference), start.descriptors(pair.current), matches_);
  times.scores_ns += matcher_.scores_ns();
  times.matches_ns += matcher_.minima_ns();
  out.matches = static_cast<int>(matches_.size());
  const std::int64_t start_ns = monotonic_ns();
  pairs_.clear();
  for (const Match& m : matches_) {
    pairs_.push_back({pair.reference.features[static_cast<std::size_t>(m.a)].point,
                      pair.current.features[static_cast<std::size_t>(m.b)].point});
  }
  clique_finder_.find(pairs_, clique_);
  out.clique = static_cast<int>(clique_.size());
  times.clique_ns += monotonic_ns() - start_ns;
}

bool Estimator::clique_motion(const FramePair& pair, Comparison& out) {
  out.motion = {};
  references_.assign(1, RigidTransform{});
  RigidTransform T_ref_cur;
  if (out.clique < params_.min_inliers || !align_points(pairs_, clique_, T_ref_cur)) return false;
  observe(pair, clique_);
  const Sigmas sigmas = match_sigmas(1.0);
  // Where the motion is refined afterwards, a start is all that is needed.
  out.motion = params_.refine ? solver_.solve(observations_, references_, T_ref_cur, sigmas, Precision::rough)
                              : solver_.solve_tightening(observations_, references_, T_ref_cur, sigmas);
  // Far false matches are compatible with nearly everything and can pull the closed form away: then the motion is
  // looked for from the predicted one and from rest, and what most members agree on is taken.
  for (const RigidTransform& start : {pair.predictions.front(), RigidTransform{}}) {
    if (out.motion.converged && out.motion.inliers >= kGoodShare * out.clique) break;
    observe(pair, clique_);
    const Motion other = solver_.solve(observations_, references_, start, sigmas);
    if (other.converged && other.inliers > out.motion.inliers) out.motion = other;
  }
  return out.motion.converged && out.motion.inliers >= params_.min_inliers;
}

// Without a clique: what the matches agree on loosely, and then ever more closely, near a guess.
bool Estimator::guided_motion(const FramePair& pair, const RigidTransform& start, Comparison& out) {
  observations_.clear();
  for (const Match& m : matches_) observations_.push_back(observe_match(pair.reference, pair.current, m));
  out.motion = {};
  Motion motion;
  motion.T_prev_cur = start;
  for (const double looser : kLooser) {
    for (Observation& o : observations_) o.inlier = true;
    motion = solver_.solve(observations_, references_, motion.T_prev_cur, match_sigmas(looser), Precision::full,
                           motion.shift_px);
    // Corners of blurred pictures lie less exactly than usual: what they agreed on before is a start as well.
    if (!motion.converged || motion.inliers < params_.min_inliers) break;
    out.motion = motion;
  }
  return out.motion.inliers >= params_.min_inliers;
}

// Of fast driving's matches too few may be true, but the features may be where a predicted motion has them.
void Estimator::predicted_motion(const FramePair& pair, Comparison& best) {
  if (!params_.refine || best.matches < params_.min_inliers) return;
  for (const RigidTransform& start : pair.predictions) {
    if (start.t.isZero()) continue;
    Comparison found = best;
    found.motion = {};
    found.motion.T_prev_cur = start;
    settle_and_judge(pair, PatchSize::usual, found);
    if (better(found, best)) best = found;
    if (best.status == Status::valid) return;
  }
}

void Estimator::observe(const FramePair& pair, const std::vector<int>& members) {
  observations_.clear();
  for (const int i : members) {
    observations_.push_back(observe_match(pair.reference, pair.current, matches_[static_cast<std::size_t>(i)]));
  }
}

Sigmas Estimator::match_sigmas(double looser) const {
  return {looser * params_.match_sigma_px, looser * params_.match_disparity_sigma_px, shift_sigma_px_};
}

Sigmas Estimator::refined_sigmas() const { return {params_.sigma_px, params_.disparity_sigma_px, shift_sigma_px_}; }

// A5 from a first motion on, and those checks of A6 that need the solution alone; again for as long as what was found
// is not enough but finds more. True when no check fails.
bool Estimator::settle(const FramePair& pair, PatchSize patches, Comparison& out) {
  for (int attempt = 0, inliers = 0; attempt < kAttempts; ++attempt) {
    if (params_.refine) refine(pair, patches, out);
    covered_ = 1.0;
    const CheckInput found = check_input(pair, out);
    out.checks = {};
    check_solution(found, pair.noise, pair.caution, params_, out.checks);
    out.eigenvalue_ratio = spread_ratio(observations_);
    if (out.checks.failed() == 0) return true;
    if (!params_.refine || out.motion.inliers <= inliers) return false;
    inliers = out.motion.inliers;
  }
  return false;
}

// Looks for the features of the references where the first motion puts them, and solves again for what is found.
void Estimator::refine(const FramePair& pair, PatchSize patches, Comparison& out) {
  const Frame& current = pair.current;
  observations_.clear();
  references_.assign(1, RigidTransform{});
  // The first features, which are spread over the picture, show where to look for the others.
  tracker_.track(pair.reference, current, out.motion.T_prev_cur, 0, {0, kPilots}, patches, errors(pair, out),
                 observations_);
  const Motion pilot = solver_.solve(observations_, references_, out.motion.T_prev_cur, refined_sigmas(),
                                     Precision::rough, out.motion.shift_px);
  if (pilot.converged && pilot.inliers >= kLeastPilots) {
    out.motion = pilot;
    shift_sigma_px_ = std::max(shift_sigma_px_, pair.noise.shift_sigma_px(pilot));
  }
  for (Observation& o : observations_) o.inlier = true;
  const auto of_pilots = static_cast<std::ptrdiff_t>(observations_.size());
  std::ptrdiff_t of_key = 0;
  FeatureRange others{kPilots};
  const bool beside_key = pair.key != nullptr && pair.key != &pair.reference;
  if (beside_key) {
    // The key frame's are worth more; the previous frame's make up the number.
    const RigidTransform T_ref_key = pair.reference.T_world_camera.inverse() * pair.key->T_world_camera;
    references_.push_back(T_ref_key);
    ViewErrors of_key_frame = errors(pair, out);
    of_key_frame.reference_velocity = pair.key->velocity;
    tracker_.track(*pair.key, current, T_ref_key.inverse() * out.motion.T_prev_cur, 1, {}, patches, of_key_frame,
                   observations_);
    of_key = static_cast<std::ptrdiff_t>(observations_.size()) - of_pilots;
    const auto enough = static_cast<std::size_t>(kEnough * params_.max_features);
    others.last = kPilots + enough - std::min(enough, observations_.size());
  }
  tracker_.track(pair.reference, current, out.motion.T_prev_cur, 0, others, patches, errors(pair, out), observations_);
  // The solver takes them grouped by reference.
  std::rotate(observations_.begin() + of_pilots, observations_.begin() + of_pilots + of_key, observations_.end());
  out.motion = solver_.solve(observations_, references_, out.motion.T_prev_cur, refined_sigmas(), Precision::full,
                             out.motion.shift_px);
  if (model_.readout_s > 0.0 && out.motion.converged) solve_with_turn(out);
  const Frame& kept = beside_key ? *pair.key : pair.reference;
  const int of_kept = beside_key ? 1 : 0;
  const auto found = std::count_if(observations_.begin(), observations_.end(),
                                   [of_kept](const Observation& o) { return o.inlier && o.reference == of_kept; });
  out.key_overlap = static_cast<double>(found) / static_cast<double>(std::max<std::size_t>(1, kept.features.size()));
}

// Rolling shutters: once more, with what the rows show of a turn during the exposure.
void Estimator::solve_with_turn(Comparison& out) {
  const TurnFit fit =
      fit_turn(observations_, references_, out.motion, model_, refined_sigmas(), kMostTurn / model_.readout_s);
  const RollingShutter shutter(model_);
  Velocity turn = Velocity::Zero();
  turn.tail<3>() = fit.rate;
  for (Observation& o : observations_) {
    o.uvd_cur = shutter.at_stamp(model_, turn, o.uvd_cur);
    o.inlier = true;
  }
  out.turn_rate += fit.rate;
  out.motion = solver_.solve(observations_, references_, out.motion.T_prev_cur, refined_sigmas(), Precision::full,
                             out.motion.shift_px);
  out.motion.covariance += fit.covariance;
}

ViewErrors Estimator::errors(const FramePair& pair, const Comparison& out) const {
  ViewErrors errors{pair.check, out.motion.shift_px, pair.noise.row_shift_px(pair.current)};
  if (model_.readout_s > 0.0) {
    const Velocities v = velocities(pair.reference, pair.current, out.motion.T_prev_cur);
    errors.reference_velocity = v.reference;
    errors.velocity = v.current;
    errors.velocity.tail<3>() += out.turn_rate;
  }
  return errors;
}

CheckInput Estimator::check_input(const FramePair& pair, const Comparison& out) const {
  std::size_t reference_features = pair.reference.features.size();
  if (references_.size() > 1) reference_features += pair.key->features.size();
  return {out.motion,
          observations_,
          references_,
          model_,
          static_cast<int>(reference_features),
          shift_sigma_px_,
          covered_,
          pair.reference.one_camera_repeats || pair.current.one_camera_repeats,
          !pair.reference.velocity_before.isZero()};
}

// A6, the rest: whether the image as a whole agrees with the motion of the inliers, and how well it is known.
// Checks here need the images; they run only where settle() found nothing.
void Estimator::judge(const FramePair& pair, Comparison& out) {
  const CheckInput before = check_input(pair, out);
  if (params_.refine) {
    out.checks[Check::hanging_camera] = check_hanging_camera(before, pair.noise, scratch_);
    const auto check_ground = [&] {
      out.checks[Check::running_ground] = check_running_ground(before, pair.noise, pair.caution, params_, scratch_);
    };
    check_ground();
    if (out.checks[Check::running_ground].ratio() > kMuchChange) {
      excuse_blur(pair);
      check_ground();
    }
    const auto count = [&](ImageConsistency::Contradicts which) {
      const CellVotes votes = consistency_.count(pair.reference, pair.current, pair.disparity, out.motion.T_prev_cur,
                                                 errors(pair, out), observations_, which);
      out.checks[Check::contradiction] = check_contradiction(votes, pair.caution, params_);
      return votes.coverage();
    };
    // Whether patches are unique takes a while to find out, and matters where many contradict.
    double coverage = count(ImageConsistency::Contradicts::any);
    if (out.checks[Check::contradiction].ratio() > kManyContradict)
      coverage = count(ImageConsistency::Contradicts::unique);
    covered_ = std::min(1.0, coverage / kFullCoverage);
  }
  const CheckInput found = check_input(pair, out);
  out.checks[Check::disparities] = check_disparities(found, pair.noise, params_);
  const Matrix6d covariance = uncertainty(found, references_.size() > 1, params_, pair.check, scratch_);
  out.checks[Check::uncertainty] = check_uncertainty(found, covariance, params_);
  out.motion.covariance = doubt_factor(found, pair.noise, out.checks[Check::running_ground]) * covariance;
  const int explained =
      other_finder_.find(pair.reference, pair.current, matches_, pairs_, out.motion, clique_finder_, solver_, others_);
  out.checks[Check::rival] = check_rival(explained);
}

// Takes off the patches' change what another blur than the reference's explains.
void Estimator::excuse_blur(const FramePair& pair) {
  std::array<double, 2> by_blur = {change_by_blur(pair.reference, pair.current, matches_, scratch_), 0.0};
  if (references_.size() > 1) {
    matcher_.match(pair.key->descriptors, pair.current.descriptors, key_matches_);
    by_blur[1] = change_by_blur(*pair.key, pair.current, key_matches_, scratch_);
  }
  for (Observation& o : observations_) {
    o.change -= static_cast<float>(by_blur[static_cast<std::size_t>(o.reference)]);
  }
}

// A second motion that a good share as many matches support: which of the two is the world's?
Evidence Estimator::check_rival(int explained) const {
  const double enough = std::max(1.0 * params_.min_inliers, params_.rival_share * explained);
  int most = 0;
  for (std::size_t i = 0; i < others_.size(); ++i) {
    most = std::max(most, std::min(others_[i].clique, others_[i].motion.inliers));
  }
  return {most / enough, std::nextafter(1.0, 0.0), true};
}

}  // namespace cliquevo::vo
