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
  columns_.resize(static_cast<int>(kernels::column_cells(width, params.num_disparities)), 1);
  costs_.resize(static_cast<int>(kernels::cost_cells(params.num_disparities)), 1);
  const auto n = static_cast<std::size_t>(width);
  found_.resize(kernels::MatchRow::kStride, kernels::MatchRow::kRows);
  texture_columns_.resize(n);
  texture_.resize(n);
  right_best_.resize(n);
}

void StripMatcher::sum_texture(const StereoParams& params, int y, ImageView<const std::uint8_t> filtered, bool first) {
  const int r = params.window / 2;
  const int rows = params.window_height / 2;
  const int width = filtered.width;
  const int neutral = params.prefilter_cap;
  const auto row = [&](int j) { return filtered.row(std::clamp(j, 0, filtered.height - 1)); };
  if (first) {
    std::fill(texture_columns_.begin(), texture_columns_.end(), 0);
    for (int j = y - rows; j <= y + rows; ++j) {
      for (int x = 0; x < width; ++x) texture_columns_[x] += std::abs(row(j)[x] - neutral);
    }
  } else {
    const std::uint8_t* in = row(y + rows);
    const std::uint8_t* out = row(y - rows - 1);
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
  const kernels::MatchRow row{found_.view().data};
  const std::int16_t* found = row.disparity();
  const std::uint16_t* best = row.best();
  const std::uint16_t* below = row.below();
  const std::uint16_t* above = row.above();
  const std::uint16_t* second = row.second();
  const bool texture = params.texture_threshold > 0;
  if (texture) sum_texture(params, y, filtered, first);
  const int enough = params.texture_threshold * params.window * params.window_height;
  const bool check_right = params.left_right_tolerance >= 0;
  if (check_right) {
    std::fill(right_best_.begin(), right_best_.end(), UINT32_MAX);
    for (int x = 0; x < width; ++x) {
      if (found[x] == kUnknownDisparity) continue;
      std::uint32_t& slot = right_best_[x - found[x]];
      slot = std::min(slot, static_cast<std::uint32_t>(best[x]) << 16 | static_cast<std::uint32_t>(0xFFFF - x));
    }
  }
  for (int x = 0; x < width; ++x) {
    out[x] = kUnknownDisparity;
    const int d = found[x];
    if (d == kUnknownDisparity) continue;
    if (texture && texture_[x] < enough) continue;
    if (second[x] * 100 <= best[x] * (100 + params.uniqueness_percent) && params.uniqueness_percent > 0) continue;
    if (check_right) {
      const int partner = 0xFFFF - static_cast<int>(right_best_[x - d] & 0xFFFF);
      if (std::abs(partner - x) > params.left_right_tolerance) continue;
    }
    // Two straight flanks of equal slope through the three costs: what a sum of absolute differences looks like.
    const int slope = std::max(below[x], above[x]) - best[x];
    const int shift =
        slope == 0 ? 0 : round_to_int(static_cast<float>(8 * (below[x] - above[x])) / static_cast<float>(slope));
    out[x] = static_cast<std::int16_t>(d * kDisparityScale + shift);
  }
}

void StripMatcher::match(const kernels::Table& kernel, const StereoParams& params, const MatchingPair& pair,
                         ImageView<const std::uint8_t> filtered, int begin, int end,
                         ImageView<std::int16_t> disparity) {
  kernels::MatchJob job{};
  job.left = pair.left.row(0);
  job.right[0] = pair.right[0].row(0);
  job.right[1] = pair.right[1].row(0);
  job.stride = pair.left.stride();
  job.channels = matching_channels(params);
  job.width = disparity.width;
  job.height = disparity.height;
  job.window = params.window;
  job.window_height = params.window_height;
  job.min_disparity = params.min_disparity;
  job.num_disparities = params.num_disparities;
  job.columns = columns_.view().data;
  job.costs = costs_.view().data;
  job.out.rows = found_.view().data;
  for (int y = begin; y < end; ++y) {
    job.y = y;
    job.first = y == begin;
    kernel.match_row(job);
    finish_row(params, y, filtered, y == begin, disparity.row(y));
  }
}

}  // namespace cliquevo::stereo
