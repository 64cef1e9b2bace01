// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/speckles.h"

#include <algorithm>
#include <bit>

namespace cliquevo::stereo {

void SpeckleFilter::prepare(int width, int height) {
  runs_.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  const auto words = (static_cast<std::size_t>(width) + 63) / 64;
  for (Bits& bits : bits_) {
    for (auto* part : {&bits.known, &bits.across, &bits.down}) part->assign(words, 0);
  }
  unknown_.assign(static_cast<std::size_t>(width), kUnknownDisparity);
}

std::int32_t SpeckleFilter::root(std::int32_t i) {
  while (runs_[i].parent != i) {
    runs_[i].parent = runs_[runs_[i].parent].parent;
    i = runs_[i].parent;
  }
  return i;
}

void SpeckleFilter::join(std::int32_t a, std::int32_t b) {
  if (runs_[a].parent == runs_[b].parent) return;
  a = root(a);
  b = root(b);
  if (a == b) return;
  if (b < a) std::swap(a, b);
  runs_[b].parent = a;
  runs_[a].pixels += runs_[b].pixels;
}

namespace {

// Calls body(x) for each bit that is set.
template <typename Body>
void each_bit(std::uint64_t bits, std::size_t word, const Body& body) {
  for (; bits != 0; bits &= bits - 1) body(static_cast<std::int32_t>(word * 64) + std::countr_zero(bits));
}

}  // namespace

// Appends the runs of row y to `count` earlier ones; the new count.
std::int32_t SpeckleFilter::find_runs(const Bits& bits, int y, std::int32_t count) {
  const std::size_t words = bits.known.size();
  std::int32_t ended = count;
  for (std::size_t i = 0; i < words; ++i) {
    const std::uint64_t next = i + 1 < words ? bits.across[i + 1] << 63 : 0;
    each_bit(bits.known[i] & ~bits.across[i], i, [&](std::int32_t x) {
      runs_[count] = {x, 0, y, count, 0};
      ++count;
    });
    each_bit(bits.known[i] & ~(bits.across[i] >> 1 | next), i, [&](std::int32_t x) {
      Run& run = runs_[ended++];
      run.end = x + 1;
      run.pixels = run.end - run.begin;
    });
  }
  return count;
}

// Runs of the row start at b, those of the row above at a.
void SpeckleFilter::join_rows(const Bits& row, const Bits& above, std::int32_t a, std::int32_t b) {
  std::uint64_t before = 0;  // the link left of the word
  for (std::size_t i = 0; i < row.down.size(); ++i) {
    // One link is enough for as long as both runs go on.
    const std::uint64_t left = row.down[i] << 1 | before;
    before = row.down[i] >> 63;
    each_bit(row.down[i] & ~(left & row.across[i] & above.across[i]), i, [&](std::int32_t x) {
      while (runs_[a].end <= x) ++a;
      while (runs_[b].end <= x) ++b;
      join(a, b);
    });
  }
}

void SpeckleFilter::remove(const kernels::Table& kernel, ImageView<std::int16_t> disparity, int size, int range) {
  std::int32_t count = 0;
  std::int32_t above = 0;  // first run of the row above
  for (int y = 0; y < disparity.height; ++y) {
    Bits& bits = bits_[y & 1];
    kernel.link_row({disparity.row(y), y > 0 ? disparity.row(y - 1) : unknown_.data(), disparity.width, range,
                     bits.known.data(), bits.across.data(), bits.down.data()});
    const std::int32_t first = count;
    count = find_runs(bits, y, count);
    if (y > 0) join_rows(bits, bits_[(y - 1) & 1], above, first);
    above = first;
  }
  // A run's parent comes before it: one step leads to the root.
  for (std::int32_t i = 0; i < count; ++i) {
    Run& run = runs_[i];
    run.parent = runs_[run.parent].parent;
    if (runs_[run.parent].pixels >= size) continue;
    std::int16_t* row = disparity.row(run.y);
    std::fill(row + run.begin, row + run.end, kUnknownDisparity);
  }
}

}  // namespace cliquevo::stereo
