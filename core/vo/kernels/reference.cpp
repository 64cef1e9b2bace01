// SPDX-License-Identifier: BSD-3-Clause
// The plain meaning of every kernel.
#include <cstdlib>

#include "core/vo/kernels/fast_circle.h"
#include "core/vo/kernels/graph_rows.h"
#include "core/vo/kernels/kernels.h"
#include "core/vo/kernels/motion_sums.h"
#include "core/vo/kernels/patch_sums.h"

namespace cliquevo::vo {
namespace {

void fast_row(const std::uint8_t* row, std::ptrdiff_t stride, int x0, int x1, int threshold, std::uint8_t* scores) {
  std::ptrdiff_t offsets[16];
  circle_offsets(stride, offsets);
  for (int x = x0; x < x1; ++x) {
    const int score = fast_score(row + x, offsets);
    scores[x] = static_cast<std::uint8_t>(score < threshold ? 0 : score);
  }
}

int maxima_row(const std::uint8_t* above, const std::uint8_t* row, const std::uint8_t* below, int x0, int x1,
               std::int16_t* columns) {
  int n = 0;
  for (int x = x0; x < x1; ++x) {
    const std::uint8_t s = row[x];
    const bool first = s > above[x - 1] && s > above[x] && s > above[x + 1] && s > row[x - 1];
    const bool last = s >= row[x + 1] && s >= below[x - 1] && s >= below[x] && s >= below[x + 1];
    if (first && last) columns[n++] = static_cast<std::int16_t>(x);
  }
  return n;
}

void sad_row(const std::uint8_t* descriptor, const std::uint8_t* others, int count, int length, std::uint16_t* scores) {
  for (int j = 0; j < count; ++j) {
    const std::uint8_t* other = others + static_cast<std::ptrdiff_t>(j) * kDescriptorStride;
    int sum = 0;
    for (int i = 0; i < length; ++i) sum += std::abs(descriptor[i] - other[i]);
    scores[j] = static_cast<std::uint16_t>(sum);
  }
}

int row_minimum(const std::uint16_t* scores, int count, int row, std::uint16_t* column_score,
                std::int16_t* column_best) {
  int best = 0;
  for (int j = 0; j < count; ++j) {
    if (scores[j] < scores[best]) best = j;
    if (scores[j] >= column_score[j]) continue;
    column_score[j] = scores[j];
    column_best[j] = static_cast<std::int16_t>(row);
  }
  return best;
}

}  // namespace

const Kernels kReferenceKernels = {
    .fast_row = fast_row,
    .maxima_row = maxima_row,
    .sad_row = sad_row,
    .row_minimum = row_minimum,
    .graph_row = graph_row_of<PlainFloats>,
    .patch_cut = patch_cut_of<PlainFloats>,
    .patch_sums = patch_sums_of<PlainFloats, true>,
    .patch_sums_across = patch_sums_of<PlainFloats, false>,
    .motion_sums = motion_sums_of<PlainPack>,
};

}  // namespace cliquevo::vo
