// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/features.h"

#include <algorithm>
#include <functional>

#include "core/vo/kernels/kernels.h"

namespace cliquevo::vo {

namespace {

constexpr std::size_t kInOrder = 2;  // corners of a cell that are put in order at a time
// Sort key of a corner: its score times this, plus how far it is from the last place in reading order.
constexpr auto kPlaces = std::uint64_t{1} << 32;

}  // namespace

FeatureDetector::FeatureDetector(const StereoModel& model, const VoParams& params)
    : model_(model), params_(params), likely_threshold_(params.corner_threshold) {
  // Of four pixels at most one is no less than its neighbours.
  corners_.reserve(static_cast<std::size_t>((model.width + 1) / 2) * static_cast<std::size_t>((model.height + 1) / 2));
  columns_.resize(static_cast<std::size_t>(model.width));
  scores_.resize(model.width, 3);
  const int across = (model.width + params.cell_px - 1) / params.cell_px;
  const int down = (model.height + params.cell_px - 1) / params.cell_px;
  cells_.resize(static_cast<std::size_t>(across) * down);
  for (int x = 0; x < model.width; ++x) cell_across_.push_back(static_cast<std::uint16_t>(x / params.cell_px));
  for (Cell& cell : cells_) {
    cell.corners.reserve(static_cast<std::size_t>((params.cell_px + 1) / 2) *
                         static_cast<std::size_t>((params.cell_px + 1) / 2));
  }
}

void FeatureDetector::detect(ImageView<const std::uint8_t> image, ImageView<const std::int16_t> disparity,
                             ImageView<const std::uint8_t> mask, double disparity_offset_px,
                             std::vector<Feature>& features) {
  // Halve the threshold until there is enough to choose from: dark and blurred pictures need less contrast. A corner's
  // score does not depend on the threshold, nor does which of two neighbours is the better one: where the last
  // picture's threshold is looked at first, all higher ones follow from the scores.
  int lowest = likely_threshold_;
  find_corners(image, lowest);
  for (;;) {
    count_usable(disparity, mask, disparity_offset_px);
    int threshold = params_.corner_threshold;
    while (threshold > lowest && usable_[static_cast<std::size_t>(threshold)] < params_.max_features) {
      threshold = next_threshold(threshold);
    }
    likely_threshold_ = threshold;
    if (usable_[static_cast<std::size_t>(threshold)] >= params_.max_features ||
        threshold <= params_.min_corner_threshold) {
      spread(disparity, threshold, features);
      return;
    }
    lowest = next_threshold(threshold);
    find_corners(image, lowest);
  }
}

int FeatureDetector::next_threshold(int threshold) const {
  return std::max(params_.min_corner_threshold, threshold / 2);
}

// Drops corners that cannot be used; how many of the others there are at each threshold.
void FeatureDetector::count_usable(ImageView<const std::int16_t> disparity, ImageView<const std::uint8_t> mask,
                                   double disparity_offset_px) {
  usable_.fill(0);
  std::size_t kept = 0;
  for (const Corner& c : corners_) {
    const std::int16_t d = disparity(c.x, c.y);
    if (d == kUnknownDisparity || !(d / static_cast<double>(kDisparityScale) + model_.doffs_px > disparity_offset_px) ||
        (!mask.empty() && mask(c.x, c.y) == 0)) {
      continue;
    }
    ++usable_[static_cast<std::size_t>(c.score)];
    corners_[kept++] = c;
  }
  corners_.resize(kept);
  for (std::size_t score = usable_.size() - 1; score > 0; --score) usable_[score - 1] += usable_[score];
}

// Corners whose score no neighbour of the eight exceeds (of equals, the first in reading order).
void FeatureDetector::find_corners(ImageView<const std::uint8_t> image, int threshold) {
  corners_.clear();
  scores_.fill(0);
  const Kernels& k = kernels();
  const int x1 = image.width - kFeatureMargin;
  const int y1 = image.height - kFeatureMargin;
  const ImageView<std::uint8_t> rows = scores_.view();
  for (int y = kFeatureMargin; y <= y1; ++y) {
    std::uint8_t* const below = rows.row(y % 3);
    if (y < y1) {
      k.fast_row(image.row(y), image.stride, kFeatureMargin, x1, threshold, below);
    } else {
      std::fill(below, below + image.width, std::uint8_t{0});
    }
    if (y == kFeatureMargin) continue;
    const std::uint8_t* const row = rows.row((y - 1) % 3);
    const int n = k.maxima_row(rows.row((y - 2) % 3), row, below, kFeatureMargin, x1, columns_.data());
    for (int i = 0; i < n; ++i) {
      const std::int16_t x = columns_[static_cast<std::size_t>(i)];
      corners_.push_back({x, static_cast<std::int16_t>(y - 1), row[x]});
    }
  }
}

// Takes the best corner of each cell, then each cell's second best, and so on, until there are enough.
void FeatureDetector::spread(ImageView<const std::int16_t> disparity, int threshold, std::vector<Feature>& features) {
  for (Cell& cell : cells_) {
    cell.corners.clear();
    cell.in_order = 0;
  }
  const int across = (model_.width + params_.cell_px - 1) / params_.cell_px;
  Cell* row = cells_.data();
  int below = params_.cell_px;  // where the next row of cells begins
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const Corner& c = corners_[i];
    if (c.score < threshold) continue;
    for (; c.y >= below; below += params_.cell_px) row += across;
    row[cell_across_[static_cast<std::size_t>(c.x)]].corners.push_back(static_cast<std::uint64_t>(c.score) * kPlaces +
                                                                       (kPlaces - 1 - i));
  }
  features.clear();
  bool any = true;
  for (std::size_t rank = 0; any; ++rank) {
    any = false;
    for (Cell& cell : cells_) {
      if (rank >= cell.corners.size()) continue;
      any = true;
      if (static_cast<int>(features.size()) >= params_.max_features) return;
      if (rank >= cell.in_order) {
        const auto from = cell.corners.begin() + static_cast<std::ptrdiff_t>(cell.in_order);
        cell.in_order = std::min(cell.in_order + kInOrder, cell.corners.size());
        std::partial_sort(from, cell.corners.begin() + static_cast<std::ptrdiff_t>(cell.in_order), cell.corners.end(),
                          std::greater<>());
      }
      const Corner& best = corners_[kPlaces - 1 - cell.corners[rank] % kPlaces];
      Feature f;
      f.x = best.x;
      f.y = best.y;
      f.score = best.score;
      f.disparity_px = disparity(f.x, f.y) / static_cast<double>(kDisparityScale);
      f.point = model_.triangulate(f.x, f.y, f.disparity_px);
      features.push_back(f);
    }
  }
}

}  // namespace cliquevo::vo
