// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/block_matcher.h"

#include <algorithm>
#include <cstdlib>

namespace cliquevo::stereo {

namespace {

// Round to nearest, ties to even, as every vector unit does it: no libm, the same bits everywhere.
int round_to_int(float v) {
  constexpr float kMagic = 12582912.0F;  // 1.5 * 2^23
  return static_cast<int>((v + kMagic) - kMagic);
}

}  // namespace

void StripMatcher::prepare(const StereoParams& params, int width) {
  const int padded = kernels::padded_disparities(params.num_disparities);
  columns_.resize(padded * width, 1);
  costs_.resize(padded * width, 1);
  const auto n = static_cast<std::size_t>(width);
  found_.resize(n);
  for (auto* v : {&best_, &below_, &above_, &second_}) v->resize(n);
  texture_columns_.resize(n);
  texture_.resize(n);
  right_best_.resize(n + static_cast<std::size_t>(std::abs(params.min_disparity)));
}

void StripMatcher::sum_texture(const StereoParams& params, int y, ImageView<const std::uint8_t> filtered, bool first) {
  const int r = params.window / 2;
  const int width = filtered.width;
  const int neutral = params.prefilter == Prefilter::xsobel ? params.prefilter_cap : 0;
  const auto row = [&](int j) { return filtered.row(std::clamp(j, 0, filtered.height - 1)); };
  if (first) {
    std::fill(texture_columns_.begin(), texture_columns_.end(), 0);
    for (int j = y - r; j <= y + r; ++j) {
      for (int x = 0; x < width; ++x) texture_columns_[x] += std::abs(row(j)[x] - neutral);
    }
  } else {
    const std::uint8_t* in = row(y + r);
    const std::uint8_t* out = row(y - r - 1);
    for (int x = 0; x < width; ++x) texture_columns_[x] += std::abs(in[x] - neutral) - std::abs(out[x] - neutral);
  }
  int sum = 0;
  for (int x = 0; x < 2 * r; ++x) sum += texture_columns_[x];
  for (int x = r; x < width - r; ++x) {
    sum += texture_columns_[x + r];
    texture_[x] = sum;
    sum -= texture_columns_[x - r];
  }
}

void StripMatcher::finish_row(const StereoParams& params, int y, ImageView<const std::uint8_t> filtered, bool first,
                              std::int16_t* out) {
  const int width = filtered.width;
  const bool texture = params.texture_threshold > 0 && params.prefilter == Prefilter::xsobel;
  if (texture) sum_texture(params, y, filtered, first);
  const int enough = params.texture_threshold * params.window * params.window;
  const bool check_right = params.left_right_tolerance >= 0;
  if (check_right) {
    std::fill(right_best_.begin(), right_best_.end(), UINT32_MAX);
    for (int x = 0; x < width; ++x) {
      if (found_[x] == kUnknownDisparity) continue;
      std::uint32_t& slot = right_best_[x - found_[x]];
      slot = std::min(slot, static_cast<std::uint32_t>(best_[x]) << 16 | static_cast<std::uint32_t>(0xFFFF - x));
    }
  }
  for (int x = 0; x < width; ++x) {
    out[x] = kUnknownDisparity;
    const int d = found_[x];
    if (d == kUnknownDisparity) continue;
    if (texture && texture_[x] < enough) continue;
    if (second_[x] * 100 <= best_[x] * (100 + params.uniqueness_percent) && params.uniqueness_percent > 0) continue;
    if (check_right) {
      const int partner = 0xFFFF - static_cast<int>(right_best_[x - d] & 0xFFFF);
      if (std::abs(partner - x) > params.left_right_tolerance) continue;
    }
    // Two straight flanks of equal slope through the three costs: what a sum of absolute differences looks like.
    const int slope = std::max(below_[x], above_[x]) - best_[x];
    const int shift =
        slope == 0 ? 0 : round_to_int(static_cast<float>(8 * (below_[x] - above_[x])) / static_cast<float>(slope));
    out[x] = static_cast<std::int16_t>(d * kDisparityScale + shift);
  }
}

void StripMatcher::match(const kernels::Table& kernel, const StereoParams& params, const std::uint8_t* left,
                         const std::uint8_t* right, std::ptrdiff_t stride, ImageView<const std::uint8_t> filtered,
                         int begin, int end, ImageView<std::int16_t> disparity) {
  kernels::MatchJob job{};
  job.left = left;
  job.right = right;
  job.stride = stride;
  job.width = disparity.width;
  job.height = disparity.height;
  job.window = params.window;
  job.min_disparity = params.min_disparity;
  job.num_disparities = params.num_disparities;
  job.columns = columns_.view().data;
  job.costs = costs_.view().data;
  job.out = {found_.data(), best_.data(), below_.data(), above_.data(), second_.data()};
  for (int y = begin; y < end; ++y) {
    job.y = y;
    job.first = y == begin;
    kernel.match_row(job);
    finish_row(params, y, filtered, y == begin, disparity.row(y));
  }
}

}  // namespace cliquevo::stereo
