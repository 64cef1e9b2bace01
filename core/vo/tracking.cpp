// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/tracking.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cliquevo::vo {

namespace {

constexpr int kSlantRadius = 5;        // px, window in which the slant of the surface is measured
constexpr double kSlantBand = 2.0;     // px, disparities farther from the feature's belong to something else
constexpr double kMaxSlant = 0.8;      // change of disparity per px; steeper surfaces are not seen alike by both eyes
constexpr double kMinDisparity = 0.1;  // px (with doffs): beyond, depth means nothing

// Linear interpolation draws a fit to half pixels: at a fraction a of a pixel its phase is off by about sin(2 pi a).
// Where to cut the template so that both patches, `shift` apart, are off by the same: a and a + shift lie evenly about
// a quarter.
float even_place(double shift) {
  const double fraction = shift - std::floor(shift + 0.5);  // -0.5 to 0.5
  return static_cast<float>(0.25 - 0.5 * fraction);
}

constexpr std::size_t kVerticalStep = 4;  // every so many features tell of the vertical error

// Eight pixels of a row of disparities.
using Words = std::int16_t __attribute__((vector_size(16)));

// Sums over one column each of the window: how many belong to the surface, their disparities less the feature's (px *
// 16), both also times their row.
struct ColumnSums {
  Words n{}, d{}, y{}, yy{}, yd{};
  void add(const std::int16_t* row, std::int16_t centre, std::int16_t dy) {
    constexpr auto kBand = static_cast<std::int16_t>(kSlantBand * kDisparityScale);
    Words raw;
    std::memcpy(&raw, row, sizeof raw);
    const Words off = raw - centre;  // an unknown disparity wraps to something far
    const Words belongs = (off <= kBand) & (off >= static_cast<std::int16_t>(-kBand));
    const Words known = off & belongs;
    n -= belongs;
    d += known;
    y -= belongs * dy;
    yy -= belongs * static_cast<std::int16_t>(dy * dy);
    yd += known * dy;
  }
};

}  // namespace

void measure_slant(ImageView<const std::int16_t> disparity, Feature& f) {
  // All sums are whole numbers of sixteenths.
  constexpr int kColumns = 2 * kSlantRadius + 1;
  constexpr int kOverlap = 16 - kColumns;  // columns that the second eight share with the first
  ColumnSums sums[2];
  const std::int16_t centre = disparity(f.x, f.y);
  for (int dy = -kSlantRadius; dy <= kSlantRadius; dy += 2) {
    const std::int16_t* row = disparity.row(f.y + dy) + f.x - kSlantRadius;
    sums[0].add(row, centre, static_cast<std::int16_t>(dy));
    sums[1].add(row + 8 - kOverlap, centre, static_cast<std::int16_t>(dy));
  }
  int whole_n = 0, whole_x = 0, whole_y = 0, whole_d = 0, whole_xx = 0, whole_xy = 0, whole_yy = 0, whole_xd = 0,
      whole_yd = 0;
  for (int column = 0; column < kColumns; ++column) {
    const ColumnSums& s = sums[column / 8];
    const int lane = column < 8 ? column : column - 8 + kOverlap;
    const int dx = column - kSlantRadius;
    whole_n += s.n[lane];
    whole_x += dx * s.n[lane];
    whole_y += s.y[lane];
    whole_d += s.d[lane];
    whole_xx += dx * dx * s.n[lane];
    whole_xy += dx * s.y[lane];
    whole_yy += s.yy[lane];
    whole_xd += dx * s.d[lane];
    whole_yd += s.yd[lane];
  }
  constexpr double kUnit = 1.0 / kDisparityScale;
  const double n = whole_n, sx = whole_x, sy = whole_y, sd = whole_d * kUnit;
  double sxx = whole_xx, sxy = whole_xy, syy = whole_yy, sxd = whole_xd * kUnit, syd = whole_yd * kUnit;
  f.disparity_dx = f.disparity_dy = 0.0;
  if (n < 16) return;
  sxx -= sx * sx / n;
  sxy -= sx * sy / n;
  syy -= sy * sy / n;
  sxd -= sx * sd / n;
  syd -= sy * sd / n;
  const double determinant = sxx * syy - sxy * sxy;
  if (determinant < 1e-3 * sxx * syy) return;
  f.disparity_dx = std::clamp((syy * sxd - sxy * syd) / determinant, -kMaxSlant, kMaxSlant);
  f.disparity_dy = std::clamp((sxx * syd - sxy * sxd) / determinant, -kMaxSlant, kMaxSlant);
}

Tracker::Tracker(const StereoModel& model, const VoParams& params) : model_(model), params_(params) {
  patch_.radius = params.refine_radius_px;
  patch_.iterations = params.refine_iterations;
  patch_.max_residual = params.refine_max_residual;
  patch_.max_shift_px = params.refine_radius_px;
}

// How much lower a feature is found in the right image: looked for on a part of the features, in turn.
void Tracker::measure_vertical(SelfCheck& check, const Frame& frame) {
  PatchParams patch = patch_;
  patch.max_shift_px = 2.0;
  const std::size_t step = check.frames() == 0 ? 1 : check.frames() < 100 ? kVerticalStep : 2 * kVerticalStep;
  Template t;
  for (std::size_t i = phase_++ % step; i < frame.features.size(); i += step) {
    const Feature& f = frame.features[i];
    const double down = check.vertical_error_px(f.x, f.y);
    const float dx = even_place(-f.disparity_px);
    const float dy = even_place(down);
    const float x = static_cast<float>(f.x) + dx;
    const float y = static_cast<float>(f.y) + dy;
    if (!cut_template(frame.left.cview(), x, y, patch.radius, t)) continue;
    Warp warp;
    warp.xx = static_cast<float>(1.0 - f.disparity_dx);
    warp.xy = static_cast<float>(-f.disparity_dy);
    const PatchFit fit = fit_patch(t, frame.right.cview(), static_cast<float>(f.x - f.disparity_px),
                                   y + static_cast<float>(down), warp, Freedom::both, patch);
    if (fit.ok) check.add_vertical(f.x, f.y, static_cast<double>(fit.y) - static_cast<double>(y));
  }
  check.update_vertical();
}

void Tracker::refine_disparities(ImageView<const std::int16_t> disparity, SelfCheck& check, Frame& frame) {
  PatchParams patch = patch_;
  patch.max_shift_px = 1.5;  // the block matcher is right to a pixel, or wrong altogether
  for (Feature& f : frame.features) measure_slant(disparity, f);
  measure_vertical(check, frame);
  Template t;
  for (Feature& f : frame.features) {
    f.raw_disparity_px = f.disparity_px;
    if (cut_template(frame.left.cview(), static_cast<float>(f.x), static_cast<float>(f.y), patch.radius, t)) {
      Warp warp;
      warp.xx = static_cast<float>(1.0 - f.disparity_dx);
      warp.xy = static_cast<float>(-f.disparity_dy);
      const PatchFit fit =
          fit_patch(t, frame.right.cview(), static_cast<float>(f.x - f.disparity_px),
                    static_cast<float>(f.y + check.vertical_error_px(f.x, f.y)), warp, Freedom::row_only, patch);
      if (fit.ok) f.raw_disparity_px = f.x - static_cast<double>(fit.x);
    }
  }
  compensate(check, frame);
}

void Tracker::compensate(const SelfCheck& check, Frame& frame) const {
  for (Feature& f : frame.features) {
    const double d = f.raw_disparity_px - check.disparity_error_px(f.x, f.y);
    f.disparity_px = std::max(d, kMinDisparity - model_.doffs_px);
    f.point = model_.triangulate(f.x, f.y, f.disparity_px);
  }
}

void Tracker::track(const Frame& reference, const Frame& current, const RigidTransform& T_ref_cur, int reference_index,
                    std::size_t first, std::size_t last, const SelfCheck& check,
                    std::vector<Observation>& observations) const {
  const RigidTransform T_cur_ref = T_ref_cur.inverse();
  const double reach = params_.refine_radius_px;
  Template t;
  Template left;
  PatchParams stereo_patch = patch_;
  stereo_patch.max_shift_px = 2.0;
  for (std::size_t i = first; i < std::min(last, reference.features.size()); ++i) {
    const Feature& f = reference.features[i];
    const Eigen::Vector3d p = T_cur_ref * f.point;
    if (p.z() < 0.05) continue;
    const auto image_of = [&](const Eigen::Vector3d& q) {
      return Eigen::Vector2d(model_.fx_px * q.x() / q.z() + model_.cx_px, model_.fy_px * q.y() / q.z() + model_.cy_px);
    };
    const Eigen::Vector2d uv = image_of(p);
    if (uv.x() < reach || uv.y() < reach || uv.x() > model_.width - 1 - reach || uv.y() > model_.height - 1 - reach) {
      continue;
    }
    // How the surface element is seen from the new place: two more of its points, moved likewise.
    const double right_d = std::max(f.disparity_px + model_.doffs_px + reach * f.disparity_dx, kMinDisparity);
    const double below_d = std::max(f.disparity_px + model_.doffs_px + reach * f.disparity_dy, kMinDisparity);
    const Eigen::Vector3d right = T_cur_ref * model_.triangulate(f.x + reach, f.y, right_d - model_.doffs_px);
    const Eigen::Vector3d below = T_cur_ref * model_.triangulate(f.x, f.y + reach, below_d - model_.doffs_px);
    if (right.z() < 0.05 || below.z() < 0.05) continue;
    const Eigen::Vector2d ax = (image_of(right) - uv) / reach;
    const Eigen::Vector2d ay = (image_of(below) - uv) / reach;
    const double area = ax.x() * ay.y() - ax.y() * ay.x();
    if (!(area > 0.2 && area < 5.0)) continue;
    Warp warp;
    warp.xx = static_cast<float>(ax.x());
    warp.yx = static_cast<float>(ax.y());
    warp.xy = static_cast<float>(ay.x());
    warp.yy = static_cast<float>(ay.y());
    if (!cut_template(reference.left.cview(), static_cast<float>(f.x), static_cast<float>(f.y), patch_.radius, t)) {
      continue;
    }
    const PatchFit fit = fit_patch(t, current.left.cview(), static_cast<float>(uv.x()), static_cast<float>(uv.y()),
                                   warp, Freedom::both, patch_);
    if (!fit.ok) continue;
    if (!cut_template(current.left.cview(), fit.x, fit.y, patch_.radius, left)) continue;
    const double expected_d = model_.fx_px * model_.baseline_m / p.z() - model_.doffs_px;
    // Slant as seen from here: disparity goes with 1 / z, so with the ratio of the disparities over that of the
    // lengths.
    const double dx = (model_.fx_px * model_.baseline_m / right.z() - model_.doffs_px - expected_d) / reach;
    const double dy = (model_.fx_px * model_.baseline_m / below.z() - model_.doffs_px - expected_d) / reach;
    Warp shear;  // gradient of disparity in the new image = (dx, dy) * A^-1
    shear.xx = static_cast<float>(1.0 - (dx * ay.y() - dy * ax.y()) / area);
    shear.xy = static_cast<float>(-(dy * ax.x() - dx * ay.x()) / area);
    const double error_d = check.disparity_error_px(fit.x, fit.y);
    const float row = fit.y + static_cast<float>(check.vertical_error_px(fit.x, fit.y));
    const PatchFit stereo = fit_patch(left, current.right.cview(), fit.x - static_cast<float>(expected_d + error_d),
                                      row, shear, Freedom::row_only, stereo_patch);
    if (!stereo.ok) continue;
    const double d = static_cast<double>(fit.x) - static_cast<double>(stereo.x) - error_d;
    if (d + model_.doffs_px < kMinDisparity) continue;
    Observation o;
    o.uvd_ref = {static_cast<double>(f.x), static_cast<double>(f.y), f.disparity_px};
    o.uvd_cur = {fit.x, fit.y, d};
    o.reference = reference_index;
    o.feature = static_cast<int>(i);
    o.brighter = fit.brighter;
    o.change = 1.0F - fit.correlation;
    o.difference = 1.0F - stereo.correlation;
    observations.push_back(o);
  }
}

}  // namespace cliquevo::vo
