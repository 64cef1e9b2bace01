// SPDX-License-Identifier: BSD-3-Clause
// Steps A2 to A3: descriptors, the full score matrix, and co-occurring minima.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/image.h"
#include "core/vo/features.h"

namespace cliquevo::vo {

// Descriptors of a frame's features, kDescriptorStride bytes each: the window around the feature without its centre.
class Descriptors {
 public:
  explicit Descriptors(int max_features);
  // window: odd, <= 11.
  void extract(ImageView<const std::uint8_t> filtered, const std::vector<Feature>& features, int window);
  // The same of 7 x 7 means of 2 x 2 px each: less detail, and twice the surroundings.
  void extract_coarse(ImageView<const std::uint8_t> filtered, const std::vector<Feature>& features);
  const std::uint8_t* operator[](int i) const { return bytes_.view().row(i); }
  const std::uint8_t* data() const { return bytes_.view().data; }
  int count() const { return count_; }
  int length() const { return length_; }

 private:
  Image<std::uint8_t> bytes_;  // one row a feature
  int count_ = 0;
  int length_ = 0;
};

struct Match {
  int a = 0;  // index of the feature in the reference frame
  int b = 0;  // in the current one
  int score = 0;
};

class Matcher {
 public:
  explicit Matcher(int max_features);
  // All pairs, no search window, no motion prior: (a, b) match iff b minimises row a and a minimises column b (of equal
  // scores, the first). Matches come in rising order of a.
  void match(const Descriptors& a, const Descriptors& b, std::vector<Match>& matches);
  // Time of the last call's two halves.
  std::int64_t scores_ns() const { return scores_ns_; }
  std::int64_t minima_ns() const { return minima_ns_; }

 private:
  Image<std::uint16_t> scores_;
  std::vector<int> row_best_;
  std::vector<std::int16_t> column_best_;
  std::vector<std::uint16_t> column_score_;
  std::int64_t scores_ns_ = 0;
  std::int64_t minima_ns_ = 0;
};

}  // namespace cliquevo::vo
