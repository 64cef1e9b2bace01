// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/speckles.h"

#include <algorithm>
#include <bit>

namespace cliquevo::stereo {

void SpeckleFilter::Bits::prepare(int width) {
  for (auto* part : {&known, &across, &down}) part->assign((static_cast<std::size_t>(width) + 63) / 64, 0);
}

void SpeckleFilter::prepare(int width, int height, int range, const RowShares& shares) {
  range_ = range;
  runs_.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
  rows_.resize(static_cast<std::size_t>(height));
  lanes_.resize(static_cast<std::size_t>(shares.workers()));
  for (int worker = 0; worker < shares.workers(); ++worker) {
    Lane& lane = lanes_[static_cast<std::size_t>(worker)];
    lane.step = RowShares::step(worker);
    lane.first = lane.step > 0 ? shares.first(worker) * width : (shares.first(worker) + 1) * width - 1;
    for (Bits& bits : lane.bits) bits.prepare(width);
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

// The root that was numbered first remains one.
void SpeckleFilter::join(std::int32_t a, std::int32_t b, std::int32_t step) {
  if (runs_[a].parent == runs_[b].parent) return;
  a = root(a);
  b = root(b);
  if (a == b) return;
  if ((b < a) == (step > 0)) std::swap(a, b);
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

void SpeckleFilter::link(const kernels::Table& kernel, ImageView<const std::int16_t> disparity, int y,
                         const std::int16_t* before, int range, Bits& bits) {
  kernel.link_row(
      {disparity.row(y), before, disparity.width, range, bits.known.data(), bits.across.data(), bits.down.data()});
}

// Numbers the runs of a row from `next` on; the number after them.
std::int32_t SpeckleFilter::find_runs(const Bits& bits, std::int32_t next, std::int32_t step) {
  const std::size_t words = bits.known.size();
  std::int32_t ended = next;
  for (std::size_t i = 0; i < words; ++i) {
    const std::uint64_t right = i + 1 < words ? bits.across[i + 1] << 63 : 0;
    each_bit(bits.known[i] & ~bits.across[i], i, [&](std::int32_t x) {
      runs_[next] = {next, 0, static_cast<std::int16_t>(x), 0};
      next += step;
    });
    each_bit(bits.known[i] & ~(bits.across[i] >> 1 | right), i, [&](std::int32_t x) {
      Run& run = runs_[ended];
      ended += step;
      run.end = static_cast<std::int16_t>(x + 1);
      run.pixels = run.end - run.begin;
    });
  }
  return next;
}

// Joins the runs of a row, b, with those of the row before, a, to which `row` has its links.
void SpeckleFilter::join_rows(const Bits& row, const Bits& before, const Row& a, const Row& b) {
  const std::int32_t step_a = RowShares::step(a.worker);
  const std::int32_t step_b = RowShares::step(b.worker);
  std::int32_t i = a.first;
  std::int32_t j = b.first;
  std::uint64_t carried = 0;  // the link left of the word
  for (std::size_t word = 0; word < row.down.size(); ++word) {
    // One link is enough for as long as both runs go on.
    const std::uint64_t left = row.down[word] << 1 | carried;
    carried = row.down[word] >> 63;
    each_bit(row.down[word] & ~(left & row.across[word] & before.across[word]), word, [&](std::int32_t x) {
      while (runs_[i].end <= x) i += step_a;
      while (runs_[j].end <= x) j += step_b;
      join(i, j, step_b);
    });
  }
}

void SpeckleFilter::start(int worker) {
  Lane& lane = lanes_[static_cast<std::size_t>(worker)];
  lane.next = lane.first;
  lane.y = -1;
}

void SpeckleFilter::add_row(const kernels::Table& kernel, int worker, ImageView<const std::int16_t> disparity, int y) {
  Lane& lane = lanes_[static_cast<std::size_t>(worker)];
  const bool first = lane.y < 0;
  Bits& before = lane.bits[lane.turn];
  lane.turn = 1 - lane.turn;
  Bits& bits = lane.bits[lane.turn];
  link(kernel, disparity, y, first ? unknown_.data() : disparity.row(lane.y), range_, bits);
  Row& row = rows_[static_cast<std::size_t>(y)];
  row = {lane.next, 0, worker};
  lane.next = row.end = find_runs(bits, lane.next, lane.step);
  if (!first) join_rows(bits, before, rows_[static_cast<std::size_t>(lane.y)], row);
  lane.y = y;
}

// A run's parent was numbered before it: one step each leads to the roots.
void SpeckleFilter::finish(int worker) {
  const Lane& lane = lanes_[static_cast<std::size_t>(worker)];
  for (std::int32_t i = lane.first; i != lane.next; i += lane.step) runs_[i].parent = runs_[runs_[i].parent].parent;
}

void SpeckleFilter::join_seams(const kernels::Table& kernel, ImageView<const std::int16_t> disparity) {
  Bits& before = lanes_[0].bits[0];
  Bits& bits = lanes_[0].bits[1];
  for (int y = 1; y < disparity.height; ++y) {
    const Row& above = rows_[static_cast<std::size_t>(y - 1)];
    const Row& row = rows_[static_cast<std::size_t>(y)];
    if (row.worker == above.worker) continue;
    link(kernel, disparity, y - 1, unknown_.data(), range_, before);
    link(kernel, disparity, y, disparity.row(y - 1), range_, bits);
    join_rows(bits, before, above, row);
  }
}

void SpeckleFilter::clean(int y, int size, std::int16_t* row) const {
  const Row& runs = rows_[static_cast<std::size_t>(y)];
  for (std::int32_t i = runs.first; i != runs.end; i += RowShares::step(runs.worker)) {
    std::int32_t root = runs_[i].parent;
    while (runs_[root].parent != root) root = runs_[root].parent;  // longer than a step only across seams
    if (runs_[root].pixels < size) std::fill(row + runs_[i].begin, row + runs_[i].end, kUnknownDisparity);
  }
}

}  // namespace cliquevo::stereo
