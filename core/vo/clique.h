// SPDX-License-Identifier: BSD-3-Clause
// Step A4: the largest set of matches that keep their mutual 3-D distances from frame to frame.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/base/camera_model.h"
#include "core/vo/vo_params.h"

namespace cliquevo::vo {

// One match's points in both camera frames, m.
struct PointPair {
  Eigen::Vector3d a;
  Eigen::Vector3d b;
};

class CliqueFinder {
 public:
  CliqueFinder(const StereoModel& model, const VoParams& params);

  // Indices of the members in the order in which they joined. Greedy, as in the paper: begin with the node of the
  // highest degree; keep the set compatible with every member; add its node of the highest degree (in the whole graph;
  // of equals, the first); stop when the set is empty.
  void find(const std::vector<PointPair>& pairs, std::vector<int>& clique);
  // The greedy clique among the named pairs of the last find(), of which there were `count`.
  void among(int count, const std::vector<int>& allowed, std::vector<int>& clique);

 private:
  void build_graph(const std::vector<PointPair>& pairs);
  void grow(int count, std::vector<std::uint64_t>& allowed, std::vector<int>& clique);
  const std::uint64_t* row(int i) const { return &adjacency_[static_cast<std::size_t>(i) * words_]; }

  StereoModel model_;
  VoParams params_;
  std::size_t words_ = 0;  // 64-bit words a row of the adjacency matrix W
  std::vector<std::uint64_t> adjacency_;
  std::vector<int> degree_;
  std::vector<std::uint64_t> candidates_;
  std::vector<float> storage_;  // the graph kernel's fields, one after the other
  std::size_t stride_ = 0;      // from one field to the next
};

}  // namespace cliquevo::vo
