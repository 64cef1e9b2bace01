// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/sharpness.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace cliquevo::vo {

namespace {

constexpr int kRadius = 3;                 // of a patch
constexpr int kBlock = 16;                 // px, side of a large part
constexpr int kBlocks = 12;                // across the picture, at most
constexpr std::size_t kMostMatches = 400;  // that are looked at, spread over all
constexpr std::size_t kLeastMatches = 20;  // for a median
// Pictures of equal blur differ by so much, in logarithms of the variance.
constexpr double kLikelyChange = 0.15;
constexpr double kChance = 3.0;                         // standard errors of the median, on top of it
constexpr double kDeviationOfMedian = 1.4826 * 1.2533;  // of a median's error, over the median deviation, times root n

// Share of the variance that goes with squared gradients: those count fine structure more.
constexpr double kAcross = 0.4;

struct Sums {
  std::uint64_t n = 0, sum = 0, squared = 0;
  void add(std::uint64_t v) {
    ++n;
    sum += v;
    squared += v * v;
  }
  double variance() const {
    const double mean = static_cast<double>(sum) / static_cast<double>(n);
    return static_cast<double>(squared) / static_cast<double>(n) - mean * mean;
  }
};

struct Patch {
  float contrast = 0.0F;         // variance of the grey levels
  std::array<float, 4> edges{};  // mean squared gradients along x, y and the two diagonals
};

Patch patch_at(ImageView<const std::uint8_t> image, const Feature& f) {
  Patch out;
  int sum = 0, squared = 0, xx = 0, yy = 0, xy = 0;
  for (int dy = -kRadius; dy <= kRadius; ++dy) {
    const std::uint8_t* row = image.row(f.y + dy) + f.x;
    for (int dx = -kRadius; dx <= kRadius; ++dx) {
      const int gx = row[dx + 1] - row[dx - 1];
      const int gy = row[dx + image.stride] - row[dx - image.stride];
      sum += row[dx];
      squared += row[dx] * row[dx];
      xx += gx * gx;
      yy += gy * gy;
      xy += gx * gy;
    }
  }
  constexpr float kPerPixel = 1.0F / ((2 * kRadius + 1) * (2 * kRadius + 1));
  const float mean = static_cast<float>(sum) * kPerPixel;
  out.contrast = static_cast<float>(squared) * kPerPixel - mean * mean;
  const float half = 0.5F * static_cast<float>(xx + yy);
  out.edges = {static_cast<float>(xx), static_cast<float>(yy), half + static_cast<float>(xy),
               half - static_cast<float>(xy)};
  for (float& e : out.edges) e *= kPerPixel;
  return out;
}

float median_of(std::vector<float>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

struct Median {
  double value, error;
};

Median median_and_error(std::vector<float>& values) {
  const float median = median_of(values);
  for (float& v : values) v = std::abs(v - median);
  const double scatter = kDeviationOfMedian * static_cast<double>(median_of(values));
  return {median, scatter / std::sqrt(static_cast<double>(values.size()))};
}

double beyond_chance(double change, double error) {
  return std::copysign(std::max(0.0, std::abs(change) - kLikelyChange - kChance * error), change);
}

// Variance of the grey levels between large parts of a picture.
double contrast_of_parts(ImageView<const std::uint8_t> image) {
  const int step_x = std::max(kBlock, image.width / kBlocks);
  const int step_y = std::max(kBlock, image.height / kBlocks);
  Sums sums;
  for (int y = 0; y + kBlock <= image.height; y += step_y) {
    for (int x = 0; x + kBlock <= image.width; x += step_x) {
      unsigned sum = 0;
      for (int j = 0; j < kBlock; ++j) {
        const std::uint8_t* row = image.row(y + j) + x;
        for (int i = 0; i < kBlock; ++i) sum += row[i];
      }
      sums.add(sum);
    }
  }
  constexpr double kPixels = kBlock * kBlock;
  return sums.n > 1 ? sums.variance() / (kPixels * kPixels) : 0.0;
}

}  // namespace

double change_by_blur(const Frame& reference, const Frame& current, const std::vector<Match>& matches,
                      std::vector<float>& scratch) {
  if (matches.size() < kLeastMatches) return 0.0;
  const double parts_before = contrast_of_parts(reference.left.cview());
  const double parts_now = contrast_of_parts(current.left.cview());
  if (!(parts_before > 1.0) || !(parts_now > 1.0)) return 0.0;
  std::array<std::array<Patch, 2>, kMostMatches> patches;
  const std::size_t step = (matches.size() + kMostMatches - 1) / kMostMatches;
  std::size_t n = 0;
  for (std::size_t i = 0; i < matches.size(); i += step, ++n) {
    patches[n] = {patch_at(reference.left.cview(), reference.features[static_cast<std::size_t>(matches[i].a)]),
                  patch_at(current.left.cview(), current.features[static_cast<std::size_t>(matches[i].b)])};
  }
  const auto change = [&](const auto& of) {
    scratch.clear();
    for (std::size_t i = 0; i < n; ++i) {
      scratch.push_back(std::log(std::max(of(patches[i][1]), 1.0F) / std::max(of(patches[i][0]), 1.0F)));
    }
    return median_and_error(scratch);
  };
  const auto [contrast, error] = change([](const Patch& p) { return p.contrast; });
  const double within = beyond_chance(contrast - std::log(parts_now / parts_before), error);
  std::array<double, 4> along{};
  double mean = 0.0, errors = 0.0;
  for (std::size_t k = 0; k < along.size(); ++k) {
    const auto [median, its_error] = change([k](const Patch& p) { return p.edges[k]; });
    along[k] = median;
    mean += 0.25 * median;
    errors += 0.25 * its_error;
  }
  double most = 0.0, least = 0.0;
  for (const double a : along) {
    most = std::max(most, beyond_chance(a - mean, errors));
    least = std::min(least, beyond_chance(a - mean, errors));
  }
  return 1.0 - std::exp(-0.5 * std::abs(within) - kAcross * (most - least));
}

}  // namespace cliquevo::vo
