// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/features.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/vo/kernels/kernels.h"

namespace cliquevo::vo {

namespace {

// More corners than this are not looked at further: the threshold was too low for the picture.
constexpr int kMaxCorners = 20000;

}  // namespace

FeatureDetector::FeatureDetector(const StereoModel& model, const VoParams& params)
    : model_(model), params_(params), likely_threshold_(params.corner_threshold) {
  corners_.reserve(kMaxCorners);
  keep_.reserve(kMaxCorners);
  row_begin_.resize(static_cast<std::size_t>(model.height) + 1);
  const int across = (model.width + params.cell_px - 1) / params.cell_px;
  const int down = (model.height + params.cell_px - 1) / params.cell_px;
  cells_.resize(static_cast<std::size_t>(across) * down);
  for (auto& cell : cells_) cell.reserve(static_cast<std::size_t>(params.cell_px) * params.cell_px / 4);
}

void FeatureDetector::detect(ImageView<const std::uint8_t> image, ImageView<const std::int16_t> disparity,
                             ImageView<const std::uint8_t> mask, double disparity_offset_px,
                             std::vector<Feature>& features) {
  // Halve the threshold until there is enough to choose from: dark and blurred pictures need less contrast. A corner's
  // score does not depend on the threshold, nor does which of two neighbours is the better one: where the last
  // picture's threshold is looked at first, all higher ones are told from the scores.
  int lowest = likely_threshold_;
  find_corners(image, lowest);
  if (corners_.size() == kMaxCorners) {
    lowest = params_.corner_threshold;
    find_corners(image, lowest);
  }
  for (;;) {
    suppress_non_maxima();
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
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const Corner& c = corners_[i];
    if (keep_[i] == 0) continue;
    const std::int16_t d = disparity(c.x, c.y);
    keep_[i] = d != kUnknownDisparity &&
               d / static_cast<double>(kDisparityScale) + model_.doffs_px > disparity_offset_px &&
               (mask.empty() || mask(c.x, c.y) != 0);
    usable_[static_cast<std::size_t>(c.score)] += keep_[i];
  }
  for (std::size_t score = usable_.size() - 1; score > 0; --score) usable_[score - 1] += usable_[score];
}

void FeatureDetector::find_corners(ImageView<const std::uint8_t> image, int threshold) {
  corners_.clear();
  std::array<std::int16_t, 4096> columns;
  std::array<std::uint8_t, 4096> scores;
  for (int y = 0; y < image.height; ++y) {
    row_begin_[static_cast<std::size_t>(y)] = static_cast<int>(corners_.size());
    if (y < kFeatureMargin || y >= image.height - kFeatureMargin) continue;
    for (int x0 = kFeatureMargin; x0 < image.width - kFeatureMargin; x0 += static_cast<int>(columns.size())) {
      const int x1 = std::min(image.width - kFeatureMargin, x0 + static_cast<int>(columns.size()));
      const int n = kernels().fast_row(image.row(y), image.stride, x0, x1, threshold, columns.data(), scores.data());
      for (int i = 0; i < n && corners_.size() < kMaxCorners; ++i) {
        corners_.push_back({columns[static_cast<std::size_t>(i)], y, scores[static_cast<std::size_t>(i)]});
      }
    }
  }
  row_begin_[static_cast<std::size_t>(image.height)] = static_cast<int>(corners_.size());
}

// Keeps corners whose score no neighbour of the eight exceeds (of equals, the first in reading order).
void FeatureDetector::suppress_non_maxima() {
  keep_.assign(corners_.size(), 1);
  const auto beats = [](const Corner& a, const Corner& b) {
    return a.score > b.score || (a.score == b.score && (a.y < b.y || (a.y == b.y && a.x < b.x)));
  };
  int above = 0;
  for (int i = 0; i < static_cast<int>(corners_.size()); ++i) {
    const Corner& c = corners_[static_cast<std::size_t>(i)];
    const auto contest = [&](int j) {
      const Corner& other = corners_[static_cast<std::size_t>(j)];
      if (std::abs(other.x - c.x) > 1) return;
      (beats(c, other) ? keep_[static_cast<std::size_t>(j)] : keep_[static_cast<std::size_t>(i)]) = 0;
    };
    if (i > 0 && corners_[static_cast<std::size_t>(i - 1)].y == c.y) contest(i - 1);
    const int end = row_begin_[static_cast<std::size_t>(c.y)];
    above = std::max(above, row_begin_[static_cast<std::size_t>(c.y - 1)]);
    if (above < end && corners_[static_cast<std::size_t>(above)].y != c.y - 1) above = end;
    while (above < end && corners_[static_cast<std::size_t>(above)].x < c.x - 1) ++above;
    for (int j = above; j < end && corners_[static_cast<std::size_t>(j)].x <= c.x + 1; ++j) contest(j);
  }
}

// Takes the best corner of each cell, then each cell's second best, and so on, until there are enough.
void FeatureDetector::spread(ImageView<const std::int16_t> disparity, int threshold, std::vector<Feature>& features) {
  for (auto& cell : cells_) cell.clear();
  const int across = (model_.width + params_.cell_px - 1) / params_.cell_px;
  for (std::size_t i = 0; i < corners_.size(); ++i) {
    const Corner& c = corners_[i];
    if (keep_[i] == 0 || c.score < threshold) continue;
    auto& cell = cells_[static_cast<std::size_t>(c.y / params_.cell_px) * static_cast<std::size_t>(across) +
                        static_cast<std::size_t>(c.x / params_.cell_px)];
    if (cell.size() < cell.capacity()) cell.push_back(c);
  }
  features.clear();
  for (auto& cell : cells_) {
    std::sort(cell.begin(), cell.end(), [](const Corner& a, const Corner& b) {
      return a.score != b.score ? a.score > b.score : (a.y != b.y ? a.y < b.y : a.x < b.x);
    });
  }
  bool any = true;
  for (std::size_t rank = 0; any; ++rank) {
    any = false;
    for (const auto& cell : cells_) {
      if (rank >= cell.size()) continue;
      any = true;
      if (static_cast<int>(features.size()) >= params_.max_features) return;
      Feature f;
      f.x = cell[rank].x;
      f.y = cell[rank].y;
      f.score = cell[rank].score;
      f.disparity_px = disparity(f.x, f.y) / static_cast<double>(kDisparityScale);
      f.point = model_.triangulate(f.x, f.y, f.disparity_px);
      features.push_back(f);
    }
  }
}

}  // namespace cliquevo::vo
