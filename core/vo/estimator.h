// SPDX-License-Identifier: BSD-3-Clause
// Steps A2' to A6 for one pair of frames: from features to a judged motion.
#pragma once

#include <span>
#include <vector>

#include "core/vo/caution.h"
#include "core/vo/checks.h"
#include "core/vo/clique.h"
#include "core/vo/frame.h"
#include "core/vo/image_consistency.h"
#include "core/vo/matches.h"
#include "core/vo/motion.h"
#include "core/vo/noise.h"
#include "core/vo/other_motions.h"
#include "core/vo/step_times.h"
#include "core/vo/tracking.h"
#include "core/vo/verdict.h"

namespace cliquevo::vo {

// What comparing two frames gave.
struct Comparison {
  Status status = Status::too_few_features;
  Checks checks;
  Motion motion;         // T_prev_cur: current camera in the reference's frame; its covariance is that of uncertainty.h
  bool started = false;  // a first motion was there to be refined
  int matches = 0;
  int clique = 0;
  double eigenvalue_ratio = 0.0;                        // spread of the inliers in the image
  Eigen::Vector3d turn_rate = Eigen::Vector3d::Zero();  // rolling shutters: beyond that of the motions, rad/s
  double key_overlap = 1.0;                             // share of the key frame's features that were found again
};

// Two frames to compare, and what is known beforehand.
struct FramePair {
  const Frame& reference;
  const Frame* key;  // an older frame that joins the solution; may be null or the reference
  const Frame& current;
  ImageView<const std::int16_t> disparity;      // of the current frame
  std::span<const RigidTransform> predictions;  // of the motion; the first is the likeliest
  const SelfCheck& check;
  const CameraNoise& noise;
  const Caution& caution;
};

class Estimator {
 public:
  Estimator(const StereoModel& model, const VoParams& params);

  // Motion of the current frame against the reference. Step times are added to `times`.
  Comparison compare(const FramePair& pair, StepTimes& times);

  // Motions beside the one that the last compare() found, the world's if it is valid.
  const OtherMotions& others() const { return others_; }

  // What the last compare() rested on, or failed with.
  const std::vector<Observation>& observations() const { return observations_; }

  // Once for a new frame, after its features: what else of it may be compared.
  void prepare(ImageView<const std::int16_t> disparity, Frame& frame) {
    consistency_.choose_test_patches(disparity, frame);
  }

 private:
  // From where a motion is looked for, in this order (core/vo/estimator.cpp).
  struct Start {
    const Descriptors& (*descriptors)(const Frame&);
    PatchSize patches;
  };
  void first_motion(const FramePair& pair, const Start& start, Comparison& out, StepTimes& times);
  bool clique_motion(const FramePair& pair, Comparison& out);
  bool guided_motion(const FramePair& pair, const RigidTransform& start, Comparison& out);
  void predicted_motion(const FramePair& pair, Comparison& best);
  void settle_and_judge(const FramePair& pair, PatchSize patches, Comparison& out);
  void match(const FramePair& pair, const Start& start, Comparison& out, StepTimes& times);
  bool settle(const FramePair& pair, PatchSize patches, Comparison& out);
  void refine(const FramePair& pair, PatchSize patches, Comparison& out);
  void solve_with_turn(Comparison& out);
  void judge(const FramePair& pair, Comparison& out);
  void excuse_blur(const FramePair& pair);
  Evidence check_rival(int explained) const;
  ViewErrors errors(const FramePair& pair, const Comparison& out) const;
  CheckInput check_input(const FramePair& pair, const Comparison& out) const;
  void observe(const FramePair& pair, const std::vector<int>& members);
  Sigmas match_sigmas(double looser) const;
  Sigmas refined_sigmas() const;

  StereoModel model_;
  VoParams params_;
  Matcher matcher_;
  CliqueFinder clique_finder_;
  MotionSolver solver_;
  Tracker tracker_;
  ImageConsistency consistency_;
  OtherMotionFinder other_finder_;
  OtherMotions others_;
  std::vector<Match> matches_;
  std::vector<Match> key_matches_;  // with the key frame, where blur changed
  std::vector<PointPair> pairs_;
  std::vector<int> clique_;
  std::vector<Observation> observations_;
  std::vector<RigidTransform> references_;
  std::vector<float> scratch_;
  double shift_sigma_px_ = 0.0;  // of the frame's common disparity error, as far as known
  double covered_ = 1.0;
};

}  // namespace cliquevo::vo
