// SPDX-License-Identifier: BSD-3-Clause
// Where the body went, thinned evenly to a bounded number of points.
#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

namespace cliquevo::ros2 {

class ThinnedPath {
 public:
  void add(const Eigen::Vector3d& position) {
    if (seen_++ % every_ != 0) return;
    points_.push_back(position.cast<float>());
    if (points_.size() < kMost) return;
    for (std::size_t i = 0; 2 * i < points_.size(); ++i) points_[i] = points_[2 * i];
    points_.resize((points_.size() + 1) / 2);
    every_ *= 2;
  }
  const std::vector<Eigen::Vector3f>& points() const { return points_; }

 private:
  static constexpr std::size_t kMost = 4096;
  std::vector<Eigen::Vector3f> points_;
  std::int64_t seen_ = 0;
  std::int64_t every_ = 1;
};

}  // namespace cliquevo::ros2
