// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/matches.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "core/base/time.h"
#include "core/vo/kernels/kernels.h"

namespace cliquevo::vo {

Descriptors::Descriptors(int max_features) : bytes_(kDescriptorStride, max_features) { bytes_.fill(0); }

void Descriptors::extract(ImageView<const std::uint8_t> filtered, const std::vector<Feature>& features, int window) {
  const int r = window / 2;
  const std::size_t side = static_cast<std::size_t>(window);
  count_ = static_cast<int>(features.size());
  length_ = window * window - 1;
  for (int i = 0; i < count_; ++i) {
    const Feature& f = features[static_cast<std::size_t>(i)];
    std::uint8_t* out = bytes_.view().row(i);
    for (int dy = -r; dy <= r; ++dy) {
      const std::uint8_t* in = filtered.row(f.y + dy) + f.x - r;
      if (dy != 0) {
        std::memcpy(out, in, side);
        out += side;
      } else {  // without the centre, so that the length is a multiple of 8
        std::memcpy(out, in, static_cast<std::size_t>(r));
        std::memcpy(out + r, in + r + 1, static_cast<std::size_t>(r));
        out += 2 * r;
      }
    }
  }
}

Matcher::Matcher(int max_features) : scores_(max_features, max_features) {
  const std::size_t n = static_cast<std::size_t>(max_features);
  row_best_.resize(n);
  column_best_.resize(n);
  column_score_.resize(n);
}

void Matcher::match(const Descriptors& a, const Descriptors& b, std::vector<Match>& matches) {
  const std::int64_t start_ns = monotonic_ns();
  const Kernels& k = kernels();
  for (int i = 0; i < a.count(); ++i) k.sad_row(a[i], b.data(), b.count(), a.length(), scores_.view().row(i));
  scores_ns_ = monotonic_ns() - start_ns;

  matches.clear();
  std::fill(column_score_.begin(), column_score_.end(), std::numeric_limits<std::uint16_t>::max());
  std::fill(column_best_.begin(), column_best_.end(), std::int16_t{-1});
  for (int i = 0; i < a.count() && b.count() > 0; ++i) {
    row_best_[static_cast<std::size_t>(i)] =
        k.row_minimum(scores_.view().row(i), b.count(), i, column_score_.data(), column_best_.data());
  }
  for (int i = 0; i < a.count() && b.count() > 0; ++i) {
    const int j = row_best_[static_cast<std::size_t>(i)];
    if (column_best_[static_cast<std::size_t>(j)] == i) matches.push_back({i, j, scores_.view()(j, i)});
  }
  minima_ns_ = monotonic_ns() - start_ns - scores_ns_;
}

}  // namespace cliquevo::vo
