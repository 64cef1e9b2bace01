// SPDX-License-Identifier: BSD-3-Clause
// Speckles: small islands of disparity that differ from all around them are mismatches more often than not.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"
#include "stereo/row_shares.h"

namespace cliquevo::stereo {

// Components of known pixels, 4-connected over steps of at most `range` (in the image's unit). Each worker joins the
// rows that it matches, one after the other; what lies on both sides of a seam between two workers is joined at the
// end.
class SpeckleFilter {
 public:
  // Memory for the worst image of this size.
  void prepare(int width, int height, int range, const RowShares& shares);

  // The rows of one worker, in the order of RowShares. The rows of different workers may be added at the same time.
  void start(int worker);
  void add_row(const kernels::Table& kernel, int worker, ImageView<const std::int16_t> disparity, int y);
  void finish(int worker);
  // Once all have finished.
  void join_seams(const kernels::Table& kernel, ImageView<const std::int16_t> disparity);

  // Makes the pixels of row y that belong to components smaller than `size` pixels unknown.
  void clean(int y, int size, std::int16_t* row) const;

 private:
  struct Run {
    std::int32_t parent;  // of equal component; itself: none
    std::int32_t pixels;
    std::int16_t begin, end;  // columns
  };
  // Bits of the pixels of a row; see kernels::LinkRow.
  struct Bits {
    std::vector<std::uint64_t> known, across, down;
    void prepare(int width);
  };
  // The runs of a row: from number `first` in steps of the worker's up to the one before `end`.
  struct Row {
    std::int32_t first, end;
    int worker;
  };
  // A worker's runs are numbered upwards from the start of its segment's memory, or downwards from the end.
  struct Lane {
    std::int32_t first, next, step;
    int y;         // of the last row
    Bits bits[2];  // of two rows, taking turns
    int turn;
  };
  static void link(const kernels::Table& kernel, ImageView<const std::int16_t> disparity, int y,
                   const std::int16_t* before, int range, Bits& bits);
  std::int32_t find_runs(const Bits& bits, std::int32_t next, std::int32_t step);
  void join_rows(const Bits& row, const Bits& before, const Row& a, const Row& b);
  std::int32_t root(std::int32_t i);
  void join(std::int32_t a, std::int32_t b, std::int32_t step);

  int range_ = 0;
  std::vector<Run> runs_;
  std::vector<Row> rows_;
  std::vector<Lane> lanes_;
  std::vector<std::int16_t> unknown_;
};

}  // namespace cliquevo::stereo
