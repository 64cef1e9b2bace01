// SPDX-License-Identifier: BSD-3-Clause
// Steps A2' to A6 for one pair of frames: from features to a judged motion.
#pragma once

#include <span>
#include <vector>

#include "core/vo/clique.h"
#include "core/vo/frame.h"
#include "core/vo/matches.h"
#include "core/vo/motion.h"
#include "core/vo/other_motions.h"
#include "core/vo/support.h"
#include "core/vo/tracking.h"
#include "core/vo/visual_odometry.h"

namespace cliquevo::vo {

// What comparing two frames gave.
struct Comparison {
  Status status = Status::too_few_features;
  Motion motion;  // T_prev_cur: current camera in the reference's frame
  int matches = 0;
  int clique = 0;
  double eigenvalue_ratio = 0.0;
  double contradiction = 0.0;    // share of the picture's cells that moved otherwise (core/vo/support.h)
  double unsteadiness_px = 0.0;  // see excess_change()
  bool contradicted = false;     // by too much of the picture, whoever is wary or not
  bool unsteady = false;         // refused for the latter
  double key_overlap = 1.0;      // share of the key frame's features that were found again
};

class Estimator {
 public:
  Estimator(const StereoModel& model, const VoParams& params);

  // Motion of `current` against `reference`; the first of `predicted` is tried as a start where the closed form's is
  // poor, and all of them where the matches give none; `key`
  // (may be null or equal to reference) is an older frame that joins the solution once the clique has given a first
  // one. wary: a frame shortly before was doubtful, so this one must be the clearer. Step times are added to
  // `times`.
  Comparison compare(const Frame& reference, const Frame* key, const Frame& current,
                     ImageView<const std::int16_t> disparity, std::span<const RigidTransform> predicted,
                     const SelfCheck& check, bool wary, StepTimes& times);

  // Motions beside the one that the last compare() found, the world's if it is valid.
  const OtherMotions& others() const { return others_; }

  // Once for a new frame, after its features: what else of it may bear witness.
  void prepare(ImageView<const std::int16_t> disparity, Frame& frame) { support_.choose_witnesses(disparity, frame); }

 private:
  bool first_motion(const Frame& reference, const Frame& current, const RigidTransform& predicted, Comparison& out,
                    StepTimes& times);
  Motion guided_motion(const Frame& reference, const Frame& current, const RigidTransform& start);
  void refine(const Frame& reference, const Frame* key, const Frame& current, const SelfCheck& check, Comparison& out);
  void settle(const Frame& reference, const Frame* key, const Frame& current, const SelfCheck& check, Comparison& out,
              double& disparity_px);
  bool rivalled(int explained) const;
  void observe(const Frame& reference, const Frame& current, const std::vector<int>& members);

  StereoModel model_;
  VoParams params_;
  Matcher matcher_;
  CliqueFinder clique_finder_;
  MotionSolver solver_;
  Tracker tracker_;
  Support support_;
  OtherMotionFinder other_finder_;
  OtherMotions others_;
  std::vector<Match> matches_;
  std::vector<PointPair> pairs_;
  std::vector<int> clique_;
  std::vector<Observation> observations_;
  std::vector<RigidTransform> references_;
  std::vector<float> changes_;
};

}  // namespace cliquevo::vo
