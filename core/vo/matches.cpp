// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/matches.h"

#include <algorithm>
#include <cstring>
#include <limits>

#include "core/base/time.h"
#include "core/vo/kernels/kernels.h"

namespace cliquevo::vo {

Descriptors::Descriptors(int max_features) : bytes_(kDescriptorStride, max_features) { bytes_.fill(0); }

namespace {

// A window without its centre, so that the length is a multiple of 8.
template <int kWindow>
void copy_window(ImageView<const std::uint8_t> filtered, int x, int y, std::uint8_t* out) {
  constexpr int kRadius = kWindow / 2;
  for (int dy = -kRadius; dy <= kRadius; ++dy) {
    const std::uint8_t* in = filtered.row(y + dy) + x - kRadius;
    if (dy != 0) {
      std::memcpy(out, in, kWindow);
      out += kWindow;
    } else {
      std::memcpy(out, in, kRadius);
      std::memcpy(out + kRadius, in + kRadius + 1, kRadius);
      out += 2 * kRadius;
    }
  }
}

// Means of 2 x 2 pixels: eight of them, from two rows of sixteen.
void halve_row(const std::uint8_t* above, const std::uint8_t* below, std::uint8_t* out) {
  using Words = std::uint16_t __attribute__((vector_size(16)));
  using Bytes = std::uint8_t __attribute__((vector_size(8)));
  Words a;
  Words b;
  std::memcpy(&a, above, sizeof a);
  std::memcpy(&b, below, sizeof b);
  constexpr std::uint16_t kLow = 0xFF;
  const Words mean = ((a & kLow) + (a >> 8) + (b & kLow) + (b >> 8) + std::uint16_t{2}) >> 2;
  const Bytes bytes = __builtin_convertvector(mean, Bytes);
  std::memcpy(out, &bytes, sizeof bytes);
}

}  // namespace

void Descriptors::extract(ImageView<const std::uint8_t> filtered, const std::vector<Feature>& features, int window) {
  count_ = static_cast<int>(features.size());
  length_ = window * window - 1;
  for (int i = 0; i < count_; ++i) {
    const Feature& f = features[static_cast<std::size_t>(i)];
    std::uint8_t* const out = bytes_.view().row(i);
    switch (window) {
      case 5:
        copy_window<5>(filtered, f.x, f.y, out);
        break;
      case 7:
        copy_window<7>(filtered, f.x, f.y, out);
        break;
      case 9:
        copy_window<9>(filtered, f.x, f.y, out);
        break;
      default:
        copy_window<11>(filtered, f.x, f.y, out);
    }
  }
}

void Descriptors::extract_coarse(ImageView<const std::uint8_t> filtered, const std::vector<Feature>& features) {
  constexpr int kRadius = 3;
  constexpr int kSide = 2 * kRadius + 1;
  static_assert(kFeatureMargin > 2 * kRadius + 1);  // a row is read to 2 px behind its window
  count_ = static_cast<int>(features.size());
  length_ = kSide * kSide - 1;
  for (int i = 0; i < count_; ++i) {
    const Feature& f = features[static_cast<std::size_t>(i)];
    std::uint8_t rows[kSide * kSide + 1];  // each written with one byte too much
    for (int dy = -kRadius; dy <= kRadius; ++dy) {
      halve_row(filtered.row(f.y + 2 * dy) + f.x - 2 * kRadius, filtered.row(f.y + 2 * dy + 1) + f.x - 2 * kRadius,
                rows + (dy + kRadius) * kSide);
    }
    constexpr int kCentre = kSide * kRadius + kRadius;
    std::uint8_t* const out = bytes_.view().row(i);
    std::memcpy(out, rows, kCentre);
    std::memcpy(out + kCentre, rows + kCentre + 1, static_cast<std::size_t>(length_) - kCentre);
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
