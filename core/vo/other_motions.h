// SPDX-License-Identifier: BSD-3-Clause
// Step A4 and A5 again on the matches that the first motion leaves over: further cliques and their motions.
#pragma once

#include <vector>

#include "core/vo/clique.h"
#include "core/vo/frame.h"
#include "core/vo/matches.h"
#include "core/vo/motion.h"
#include "core/vo/vo_params.h"

namespace cliquevo::vo {

struct OtherMotion {
  Motion motion;
  int clique = 0;                         // size of the clique that it comes from
  std::vector<Observation> observations;  // of the matches that move so ...
  std::vector<Match> matches;             // ... and these, one for one
};

// A list whose items keep their memory.
class OtherMotions {
 public:
  OtherMotions(std::size_t most, std::size_t max_features);
  void clear() { count_ = 0; }
  bool full() const { return count_ == items_.size(); }
  OtherMotion& add() { return items_[count_++]; }
  std::size_t size() const { return count_; }
  const OtherMotion& operator[](std::size_t i) const { return items_[i]; }

 private:
  std::vector<OtherMotion> items_;
  std::size_t count_ = 0;
};

// `reference` and `current`, as the solver takes them.
Observation observe_match(const Frame& reference, const Frame& current, const Match& match);

class OtherMotionFinder {
 public:
  explicit OtherMotionFinder(const VoParams& params);

  // To be called after clique_finder.find(pairs), where `pairs` are the points of `matches`. Fills `others` with the
  // motions of cliques among the matches that `first` does not explain, each plainly another one than `first`, of at
  // least min_mover_points matches. Returns how many matches `first` explains.
  int find(const Frame& reference, const Frame& current, const std::vector<Match>& matches,
           const std::vector<PointPair>& pairs, const Motion& first, CliqueFinder& clique_finder, MotionSolver& solver,
           OtherMotions& others);

 private:
  void solve(const Frame& reference, const Frame& current, const std::vector<Match>& matches,
             const std::vector<PointPair>& pairs, const Motion& first, MotionSolver& solver, OtherMotions& others);

  VoParams params_;
  std::vector<RigidTransform> references_;
  std::vector<Observation> observations_;
  std::vector<int> unexplained_;
  std::vector<int> clique_;
  std::vector<int> left_;
};

}  // namespace cliquevo::vo
