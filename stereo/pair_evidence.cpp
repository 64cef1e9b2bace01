// SPDX-License-Identifier: BSD-3-Clause
#include "stereo/pair_evidence.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "stereo/rectify.h"

namespace cliquevo::stereo {

namespace {

using View = ImageView<const std::uint8_t>;

constexpr int kCoarseWidth = 320;  // images are searched at this width or below
constexpr int kCells = 16;         // a row, each with its best corner
constexpr int kHalf = 4;           // of a patch
constexpr int kArea = (2 * kHalf + 1) * (2 * kHalf + 1);
constexpr float kLeastScore = 0.8F;     // correlation of the best place
constexpr float kLeastMargin = 0.05F;   // by which it must beat others
constexpr int kNear = 3;                // px around the best place that are no other
constexpr double kLeastContrast = 6.0;  // standard deviation of a patch

struct Point {
  int x = 0;
  int y = 0;
};

Image<std::uint8_t> reduced(View from, int factor) {
  Image<std::uint8_t> out;
  out.resize(from.width / factor, from.height / factor);
  const int area = factor * factor;
  for (int y = 0; y < out.height(); ++y) {
    for (int x = 0; x < out.width(); ++x) {
      int sum = 0;
      for (int v = 0; v < factor; ++v) {
        for (int u = 0; u < factor; ++u) sum += from(x * factor + u, y * factor + v);
      }
      out.view()(x, y) = static_cast<std::uint8_t>((sum + area / 2) / area);
    }
  }
  return out;
}

// An image with the mean and the contrast of the patch about each pixel.
struct Field {
  View image;
  std::vector<float> mean;
  std::vector<float> scale;  // 1 / length of the patch less its mean; 0 = no contrast

  explicit Field(View of) : image(of) {
    mean.assign(static_cast<std::size_t>(of.width) * static_cast<std::size_t>(of.height), 0.0F);
    scale = mean;
    for (int y = kHalf; y < of.height - kHalf; ++y) {
      for (int x = kHalf; x < of.width - kHalf; ++x) {
        const Sums sums = sums_at(of, {x, y});
        mean[at({x, y})] = sums.mean;
        scale[at({x, y})] = sums.scale;
      }
    }
  }
  std::size_t at(Point p) const {
    return static_cast<std::size_t>(p.y) * static_cast<std::size_t>(image.width) + static_cast<std::size_t>(p.x);
  }
  struct Sums {
    float mean, scale;
  };
  static Sums sums_at(View image, Point p) {
    int sum = 0;
    int squares = 0;
    for (int v = -kHalf; v <= kHalf; ++v) {
      const std::uint8_t* row = image.row(p.y + v) + p.x - kHalf;
      for (int u = 0; u <= 2 * kHalf; ++u) {
        sum += row[u];
        squares += row[u] * row[u];
      }
    }
    const double mean = static_cast<double>(sum) / kArea;
    const double square = squares - sum * mean;
    const bool plain = square < kLeastContrast * kLeastContrast * kArea;
    return {static_cast<float>(mean), plain ? 0.0F : static_cast<float>(1.0 / std::sqrt(square))};
  }
};

// A patch to be looked for.
struct Patch {
  View image;
  Point at;
  Field::Sums sums;
};

float correlation(const Patch& a, View image, Point p, const Field::Sums& sums) {
  int products = 0;
  for (int v = -kHalf; v <= kHalf; ++v) {
    const std::uint8_t* row_a = a.image.row(a.at.y + v) + a.at.x - kHalf;
    const std::uint8_t* row_b = image.row(p.y + v) + p.x - kHalf;
    for (int u = 0; u <= 2 * kHalf; ++u) products += row_a[u] * row_b[u];
  }
  return (static_cast<float>(products) - kArea * a.sums.mean * sums.mean) * a.sums.scale * sums.scale;
}

Patch patch_at(View image, Point at) { return {image, at, Field::sums_at(image, at)}; }

bool inside(View image, Point p) {
  return p.x >= kHalf && p.y >= kHalf && p.x < image.width - kHalf && p.y < image.height - kHalf;
}

// The best corner (Shi and Tomasi) of each cell.
std::vector<Point> corners_of(View image) {
  const int cell = std::max(8, image.width / kCells);
  std::vector<Point> out;
  for (int top = 2 * kHalf; top + cell <= image.height - kHalf; top += cell) {
    for (int left = 2 * kHalf; left + cell <= image.width - kHalf; left += cell) {
      double best = 0.0;
      Point at;
      for (int y = top; y < top + cell; y += 2) {
        for (int x = left; x < left + cell; x += 2) {
          double xx = 0.0;
          double xy = 0.0;
          double yy = 0.0;
          for (int v = -2; v <= 2; ++v) {
            for (int u = -2; u <= 2; ++u) {
              const double gx = image(x + u + 1, y + v) - image(x + u - 1, y + v);
              const double gy = image(x + u, y + v + 1) - image(x + u, y + v - 1);
              xx += gx * gx;
              xy += gx * gy;
              yy += gy * gy;
            }
          }
          const double least = 0.5 * (xx + yy) - std::sqrt(0.25 * (xx - yy) * (xx - yy) + xy * xy);
          if (least > best) best = least, at = {x, y};
        }
      }
      if (best > 25.0 * 4.0 * 16.0) out.push_back(at);  // gradients of 4 grey levels
    }
  }
  return out;
}

struct Range {
  int left, right, up, down;
};

// The place of a patch, where one is clearly the best. `field` of the image where it has one.
std::optional<Point> place_of(const Patch& patch, View image, const Field* field, Point about, const Range& range) {
  if (patch.sums.scale == 0.0F) return std::nullopt;
  const int width = range.right - range.left + 1;
  const int height = range.down - range.up + 1;
  std::vector<float> scores(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), -1.0F);
  float best = -1.0F;
  Point at;
  std::size_t i = 0;
  for (int v = range.up; v <= range.down; ++v) {
    for (int u = range.left; u <= range.right; ++u, ++i) {
      const Point p{about.x + u, about.y + v};
      if (!inside(image, p)) continue;
      const Field::Sums sums = field != nullptr ? Field::Sums{field->mean[field->at(p)], field->scale[field->at(p)]}
                                                : Field::sums_at(image, p);
      if (sums.scale == 0.0F) continue;
      scores[i] = correlation(patch, image, p, sums);
      if (scores[i] > best) best = scores[i], at = p;
    }
  }
  if (best < kLeastScore) return std::nullopt;
  i = 0;
  for (int v = range.up; v <= range.down; ++v) {
    for (int u = range.left; u <= range.right; ++u, ++i) {
      const bool near = std::abs(about.x + u - at.x) <= kNear && std::abs(about.y + v - at.y) <= kNear;
      if (!near && scores[i] > best - kLeastMargin) return std::nullopt;
    }
  }
  return at;
}

// Vertex of the parabola through three scores, -0.5 to 0.5.
double vertex(double before, double at, double behind) {
  const double bend = before - 2.0 * at + behind;
  return bend < 0.0 ? std::clamp(0.5 * (before - behind) / bend, -0.5, 0.5) : 0.0;
}

}  // namespace

void RowEvidence::add(const RowEvidence& more) {
  corners += more.corners;
  off_px.insert(off_px.end(), more.off_px.begin(), more.off_px.end());
  shift_px.insert(shift_px.end(), more.shift_px.begin(), more.shift_px.end());
}

double RowEvidence::share_within(double rows) const {
  const auto count = std::count_if(off_px.begin(), off_px.end(), [rows](float off) { return std::abs(off) <= rows; });
  return corners > 0 ? static_cast<double>(count) / corners : 0.0;
}

double RowEvidence::median_off_px() const {
  if (off_px.empty()) return 1e9;
  std::vector<float> off(off_px);
  for (float& value : off) value = std::abs(value);
  const auto middle = off.begin() + static_cast<std::ptrdiff_t>(off.size() / 2);
  std::nth_element(off.begin(), middle, off.end());
  return *middle;
}

double RowEvidence::disparity_px(double share) const {
  if (shift_px.empty()) return 0.0;
  std::vector<float> shift(shift_px);
  const auto i = static_cast<std::size_t>(share * static_cast<double>(shift.size() - 1));
  const auto at = shift.begin() + static_cast<std::ptrdiff_t>(i);
  std::nth_element(shift.begin(), at, shift.end());
  return *at;
}

RowEvidence measure_rows(View left, View right) {
  RowEvidence out;
  if (left.empty() || !left.same_size(right.width, right.height) || left.width < 64 || left.height < 48) return out;
  const int factor = std::max(1, (left.width + kCoarseWidth - 1) / kCoarseWidth);
  const Image<std::uint8_t> coarse_left = reduced(left, factor);
  const Image<std::uint8_t> coarse_right = reduced(right, factor);
  const View l = coarse_left.cview();
  const View r = coarse_right.cview();
  const int rows = std::max(4, l.height / 20);
  const Range forward{-l.width / 4, l.width / 16, -rows, rows};
  const Range back{-l.width / 16, l.width / 4, -rows, rows};
  const Field field_left(l);
  const Field field_right(r);
  for (const Point corner : corners_of(l)) {
    ++out.corners;
    const auto found = place_of(patch_at(l, corner), r, &field_right, corner, forward);
    if (!found) continue;
    const auto returned = place_of(patch_at(r, *found), l, &field_left, *found, back);
    if (!returned || std::abs(returned->x - corner.x) > 1 || std::abs(returned->y - corner.y) > 1) continue;
    // At full size, where the patches see more.
    const Point fine{corner.x * factor + factor / 2, corner.y * factor + factor / 2};
    const Point guess{found->x * factor + factor / 2, found->y * factor + factor / 2};
    if (!inside(left, fine)) continue;
    const int reach = factor + 1;
    const Patch patch = patch_at(left, fine);
    const auto refined = place_of(patch, right, nullptr, guess, {-reach, reach, -reach, reach});
    if (!refined) continue;
    const auto score = [&](int dx, int dy) {
      const Point p{refined->x + dx, refined->y + dy};
      return inside(right, p) ? correlation(patch, right, p, Field::sums_at(right, p)) : -1.0F;
    };
    const float at = score(0, 0);
    out.off_px.push_back(static_cast<float>(refined->y + vertex(score(0, -1), at, score(0, 1)) - fine.y));
    out.shift_px.push_back(static_cast<float>(fine.x - refined->x - vertex(score(-1, 0), at, score(1, 0))));
  }
  return out;
}

Result<RowEvidence> measure_rows(const StereoCalibration& calibration, View left, View right) {
  auto rectifier = Rectifier::make(calibration);
  if (!rectifier) return rectifier.error();
  Image<std::uint8_t> l;
  Image<std::uint8_t> r;
  for (Image<std::uint8_t>* image : {&l, &r}) image->resize(rectifier->model().width, rectifier->model().height);
  if (auto ok = rectifier->rectify(CameraSide::left, left, l.view()); !ok) return ok.error();
  if (auto ok = rectifier->rectify(CameraSide::right, right, r.view()); !ok) return ok.error();
  return measure_rows(l.cview(), r.cview());
}

}  // namespace cliquevo::stereo
