// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/block_matcher.h"

#include <algorithm>

namespace cliquevo::stereo {

void StripMatcher::prepare(const StereoParams& params, int width) {
  columns_.resize(static_cast<int>(kernels::column_cells(width, params.num_disparities)), 1);
  costs_.resize(static_cast<int>(kernels::cost_cells(params.num_disparities)), 1);
  const auto n = static_cast<std::size_t>(width);
  found_.resize(kernels::MatchRow::kStride, kernels::MatchRow::kRows);
  neutral_.assign(n, static_cast<std::uint8_t>(params.prefilter_cap));
  texture_columns_.resize(n);
  texture_.resize(n);
  right_best_.resize(3 * n);
  astray_.resize(n);
}

void StripMatcher::sum_texture(const kernels::Table& kernel, const StereoParams& params, int y, int step,
                               ImageView<const std::uint8_t> filtered, bool first) {
  const int rows = params.window_height / 2;
  const int neutral = params.prefilter_cap;
  const auto row = [&](int j) { return filtered.row(std::clamp(j, 0, filtered.height - 1)); };
  if (first) {
    std::fill(texture_columns_.begin(), texture_columns_.end(), std::uint16_t{0});
    for (int j = y - rows; j <= y + rows; ++j) {
      kernel.texture_columns(row(j), neutral_.data(), neutral, filtered.width, texture_columns_.data());
    }
  } else {
    kernel.texture_columns(row(y + step * rows), row(y - step * (rows + 1)), neutral, filtered.width,
                           texture_columns_.data());
  }
  kernel.texture_sums(texture_columns_.data(), filtered.width, params.window / 2, texture_.data());
}

void StripMatcher::match(const kernels::Table& kernel, const StereoParams& params, const MatchingPair& pair,
                         ImageView<const std::uint8_t> filtered, int y, int step, bool first,
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
  job.y = y;
  job.step = step;
  job.first = first;
  job.second = params.uniqueness_percent > 0;
  job.columns = columns_.view().data;
  job.costs = costs_.view().data;
  job.out.rows = found_.view().data;
  kernel.match_row(job);
  if (params.texture_threshold > 0) sum_texture(kernel, params, y, step, filtered, first);
  if (params.left_right_tolerance >= 0) {
    kernel.cross_check({job.out, job.width, right_best_.data(), astray_.data()});
  }
  kernel.finish_row({job.out, astray_.data(), texture_.data(), job.width, params.uniqueness_percent,
                     params.texture_threshold * params.window * params.window_height, params.left_right_tolerance},
                    disparity.row(y));
}

}  // namespace cliquevo::stereo
