// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/camera_order.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cliquevo::stereo {

namespace {

constexpr int kReducedWidth = 256;
constexpr int kMostDisparity = 64;  // px of the reduced image
constexpr int kRows = 2;            // by which raw images may be off, reduced

// A pair is evidence when this share of it matches one way, and this many times more than the other way.
constexpr double kLeastShare = 0.12;
constexpr double kLeastRatio = 3.0;
constexpr int kLeastPairs = 2;
constexpr int kEnoughPairs = 6;
constexpr int kSparse = 32;  // every so many pairs while nothing is known

StereoParams params_for(int width) {
  StereoParams p;
  p.window = 11;
  p.window_height = 7;
  p.min_disparity = 1;
  p.num_disparities = std::clamp(width / 3 / 16 * 16, 16, kMostDisparity);
  p.uniqueness_percent = 15;
  p.texture_threshold = 4;
  p.left_right_tolerance = 1;
  p.speckle_size = 40;
  p.smoothing = 0;
  return p;
}

}  // namespace

bool are_identical(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right) {
  constexpr double kLeastDeviation = 6.0;  // grey levels: bare images are alike without being the same
  constexpr double kLeastEqual = 0.99;
  if (left.empty() || right.empty() || !left.same_size(right.width, right.height)) return false;
  std::int64_t equal = 0;
  std::int64_t count = 0;
  double sum = 0.0;
  double squares = 0.0;
  for (int y = 0; y < left.height; y += 4) {
    const std::uint8_t* l = left.row(y);
    const std::uint8_t* r = right.row(y);
    for (int x = 0; x < left.width; x += 3) {
      equal += std::abs(l[x] - r[x]) <= 1 ? 1 : 0;
      ++count;
      sum += l[x];
      squares += static_cast<double>(l[x]) * l[x];
    }
  }
  const auto n = static_cast<double>(count);
  const double variance = squares / n - sum / n * (sum / n);
  return variance > kLeastDeviation * kLeastDeviation && static_cast<double>(equal) >= kLeastEqual * n;
}

CameraOrderCheck::CameraOrderCheck(int width, int height, int factor, DenseStereo dense)
    : width_(width), height_(height), factor_(factor), dense_(std::move(dense)) {
  for (Image<std::uint8_t>* image : {&left_, &right_, &moved_, &filtered_}) {
    image->resize(width / factor, height / factor);
    image->fill(0);
  }
  disparity_.resize(width / factor, height / factor);
}

Result<CameraOrderCheck> CameraOrderCheck::make(int width, int height) {
  const int factor = std::max(1, (width + kReducedWidth - 1) / kReducedWidth);
  auto dense = DenseStereo::make(params_for(width / factor), width / factor, height / factor);
  if (!dense) return dense.error();
  return CameraOrderCheck(width, height, factor, std::move(*dense));
}

void CameraOrderCheck::reduce(ImageView<const std::uint8_t> from, Image<std::uint8_t>& to) const {
  const ImageView<std::uint8_t> out = to.view();
  const int area = factor_ * factor_;
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      int sum = 0;
      for (int v = 0; v < factor_; ++v) {
        const std::uint8_t* row = from.row(y * factor_ + v) + static_cast<std::ptrdiff_t>(x) * factor_;
        for (int u = 0; u < factor_; ++u) sum += row[u];
      }
      out(x, y) = static_cast<std::uint8_t>((sum + area / 2) / area);
    }
  }
}

// The best share over a few rows up and down.
double CameraOrderCheck::matched_share(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right) {
  double best = 0.0;
  disparity_.fill(kUnknownDisparity);
  for (int shift = -kRows; shift <= kRows; ++shift) {
    // Rows that have no partner match the border again; they are few.
    for (int y = 0; y < right.height; ++y) {
      const std::uint8_t* from = right.row(std::clamp(y + shift, 0, right.height - 1));
      std::copy(from, from + right.width, moved_.view().row(y));
    }
    if (!dense_.compute(left, moved_.cview(), filtered_.view(), disparity_.view())) return 0.0;
    std::int64_t known = 0;
    const ImageView<const std::int16_t> d = disparity_.cview();
    for (int y = 0; y < d.height; ++y)
      known += std::count_if(d.row(y), d.row(y) + d.width, [](std::int16_t v) { return v != kUnknownDisparity; });
    best = std::max(best, static_cast<double>(known) / (static_cast<double>(d.width) * d.height));
  }
  return best;
}

OrderEvidence CameraOrderCheck::measure(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right) {
  OrderEvidence out;
  if (left.empty() || !left.same_size(width_, height_) || !right.same_size(width_, height_)) return out;
  out.identical = are_identical(left, right);
  reduce(left, left_);
  reduce(right, right_);
  out.forward = matched_share(left_.cview(), right_.cview());
  out.backward = matched_share(right_.cview(), left_.cview());
  return out;
}

double CameraOrderCheck::measure_forward(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right) {
  if (left.empty() || !left.same_size(width_, height_) || !right.same_size(width_, height_)) return 0.0;
  reduce(left, left_);
  reduce(right, right_);
  return matched_share(left_.cview(), right_.cview());
}

bool CameraOrderCheck::add(const OrderEvidence& seen) {
  ++pairs_;
  identical_ += seen.identical ? 1 : 0;
  forward_ += seen.forward;
  backward_ += seen.backward;
  const CameraOrder before = std::exchange(order_, judge());
  return before != order_;
}

CameraOrder CameraOrderCheck::judge() const {
  if (pairs_ < kLeastPairs) return CameraOrder::unknown;
  if (identical_ == pairs_) return CameraOrder::same;
  const double most = std::max(forward_, backward_) / pairs_;
  const double least = std::min(forward_, backward_) / pairs_;
  if (most < kLeastShare || most < kLeastRatio * least) return CameraOrder::unknown;
  return forward_ > backward_ ? CameraOrder::as_said : CameraOrder::exchanged;
}

bool CameraOrderCheck::wants(std::int64_t number) const {
  if (number < kEnoughPairs) return true;
  return order_ == CameraOrder::unknown && number % kSparse == 0;
}

std::string describe(CameraOrder order) {
  switch (order) {
    case CameraOrder::exchanged:
      return "left and right are exchanged: the left image is the right camera's (swap the files or cables, or say "
             "--swap-eyes or source.swap_eyes)";
    case CameraOrder::same:
      return "left and right are the same picture: there is no depth in it (give each side its own images or camera)";
    case CameraOrder::unknown:
    case CameraOrder::as_said:
      break;
  }
  return {};
}

}  // namespace cliquevo::stereo
