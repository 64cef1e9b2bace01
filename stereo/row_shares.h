// SPDX-License-Identifier: BSD-3-Clause
// Who matches which rows. Two workers share a segment of the image and come towards each other from its ends until no
// row is left between them: whoever is held up by the machine does less.
#pragma once

#include <atomic>
#include <vector>

namespace cliquevo::stereo {

class RowShares {
 public:
  RowShares(int workers, int height)
      : workers_(workers), segments_(static_cast<std::size_t>(workers + 1) / 2), left_(segments_.size()) {
    for (int i = 0; i < static_cast<int>(segments_.size()); ++i) {
      const int after = 2 * i + 2 < workers ? 2 * i + 2 : workers;
      segments_[static_cast<std::size_t>(i)] = {height * 2 * i / workers, height * after / workers};
    }
  }

  int workers() const { return workers_; }
  // 1: from the top of the segment downwards, -1: from its bottom upwards.
  static int step(int worker) { return worker % 2 == 0 ? 1 : -1; }
  int first(int worker) const { return step(worker) > 0 ? segment(worker).begin : segment(worker).end - 1; }

  // Before each image.
  void restart() {
    for (std::size_t i = 0; i < segments_.size(); ++i) left_[i].store(segments_[i].end - segments_[i].begin);
  }
  // Whether the worker is to match one more row.
  bool one_more(int worker) { return left_[static_cast<std::size_t>(worker) / 2].fetch_sub(1) > 0; }

 private:
  struct Segment {
    int begin, end;  // rows
  };
  const Segment& segment(int worker) const { return segments_[static_cast<std::size_t>(worker) / 2]; }

  int workers_;
  std::vector<Segment> segments_;
  std::vector<std::atomic<int>> left_;  // rows of each segment that nobody has taken
};

}  // namespace cliquevo::stereo
