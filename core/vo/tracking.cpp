// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/tracking.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cliquevo::vo {

namespace {

constexpr int kSlantRadius = 5;     // px, window in which the slant of the surface is measured
constexpr double kSlantBand = 2.0;  // px, disparities farther from the feature's belong to something else
constexpr double kMaxSlant = 0.8;   // change of disparity per px; steeper surfaces are not seen alike by both cameras

// Linear interpolation draws a fit to half pixels: at a fraction a of a pixel its phase is off by about sin(2 pi a).
// Where to cut the template so that both patches, `shift` apart, are off by the same: a and a + shift lie evenly about
// a quarter.
float even_place(double shift) {
  const double fraction = shift - std::floor(shift + 0.5);  // -0.5 to 0.5
  return static_cast<float>(0.25 - 0.5 * fraction);
}

constexpr std::size_t kVerticalStep = 4;    // every so many features are measured for rows
constexpr std::size_t kLeastRows = 8;       // of them suffice for a frame's own error and noise
constexpr double kMedianOfNormal = 1.4826;  // standard deviation over median absolute deviation
// Patches are the same where they differ by no more than twice the noise, or share so much of their contrast.
constexpr double kNoiseGate = 2.0;
constexpr double kFirstGrey = 6.0;        // before noise was measured
constexpr int kLargePatch = 2;            // times the usual radius
constexpr double kStereoShift_px = 2.0;   // from where the disparity is expected
constexpr double kMatcherShift_px = 1.5;  // the block matcher is right to a pixel, or wrong altogether
constexpr double kMostWarp = 5.0;         // of a patch's area: seen too differently to compare

double median_of(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// From the left to the right image, for the slant of the surface.
Warp slanted(const Feature& f) {
  Warp warp;
  warp.xx = static_cast<float>(1.0 - f.disparity_dx);
  warp.xy = static_cast<float>(-f.disparity_dy);
  return warp;
}

// Eight pixels of a row of disparities.
using Words = std::int16_t __attribute__((vector_size(16)));
using UnsignedWords = std::uint16_t __attribute__((vector_size(16)));

// Sums over one column each of the window: how many belong to the surface, their disparities less the feature's (px *
// 16), both also times their row.
struct ColumnSums {
  Words n{}, d{}, y{}, yy{}, yd{};
  void add(const std::int16_t* row, std::int16_t centre, std::int16_t dy) {
    constexpr auto kBand = static_cast<std::int16_t>(kSlantBand * kDisparityScale);
    Words raw;
    std::memcpy(&raw, row, sizeof raw);
    // An unknown disparity wraps to something far.
    const auto off = reinterpret_cast<Words>(reinterpret_cast<UnsignedWords>(raw) - static_cast<std::uint16_t>(centre));
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

Tracker::Tracker(const StereoModel& model, const VoParams& params) : model_(model), shutter_(model), params_(params) {
  patch_.radius = params.refine_radius_px;
  patch_.iterations = params.refine_iterations;
  patch_.min_correlation = params.min_patch_correlation;
  patch_.max_shift_px = params.refine_radius_px;
  large_patch_ = patch_;
  large_patch_.radius = std::min(kMaxPatchRadius, kLargePatch * params.refine_radius_px);
  large_patch_.max_shift_px = large_patch_.radius;
  set_noise(kFirstGrey);
}

void Tracker::set_noise(double grey_levels) {
  patch_.max_residual = large_patch_.max_residual = kNoiseGate * grey_levels;
}

void Tracker::measure_views(ImageView<const std::int16_t> disparity, SelfCheck& check, Frame& frame) {
  for (Feature& f : frame.features) measure_slant(disparity, f);
  rows_.clear();
  greys_.clear();
  PatchParams patch = patch_;
  patch.max_shift_px = kStereoShift_px;
  const std::size_t step = check.frames() == 0 ? 1 : check.frames() < 100 ? kVerticalStep : 2 * kVerticalStep;
  Template t;
  for (std::size_t i = phase_++ % step; i < frame.features.size(); i += step) {
    const Feature& f = frame.features[i];
    const double down = check.vertical_error_px(f.x, f.y);
    const float x = static_cast<float>(f.x) + static_cast<float>(even_place(-f.disparity_px));
    const float y = static_cast<float>(f.y) + static_cast<float>(even_place(down));
    if (!cut_template(frame.left.cview(), x, y, patch.radius, t)) continue;
    const PatchFit fit = fit_patch(t, frame.right.cview(), static_cast<float>(f.x - f.disparity_px),
                                   y + static_cast<float>(down), slanted(f), SearchAxes::both, patch);
    if (!fit.ok) continue;
    const double lower = static_cast<double>(fit.y) - static_cast<double>(y);
    check.add_vertical(f.x, f.y, lower);
    rows_.push_back(lower - down);
    greys_.push_back(static_cast<double>(fit.residual));
  }
  check.update_vertical();
  frame.row_shift_px = frame.row_scatter_px = frame.grey_scatter = 0.0;
  if (rows_.size() < kLeastRows) return;
  frame.row_shift_px = median_of(rows_);
  for (double& row : rows_) row = std::abs(row - frame.row_shift_px);
  frame.row_scatter_px = kMedianOfNormal * median_of(rows_);
  frame.grey_scatter = median_of(greys_);
}

void Tracker::refine_disparities(const ViewErrors& errors, Frame& frame) const {
  PatchParams patch = patch_;
  patch.max_shift_px = kMatcherShift_px;
  Template t;
  for (Feature& f : frame.features) {
    f.raw_disparity_px = f.disparity_px;
    if (!cut_template(frame.left.cview(), static_cast<float>(f.x), static_cast<float>(f.y), patch.radius, t)) continue;
    const PatchFit fit =
        fit_patch(t, frame.right.cview(), static_cast<float>(f.x - f.disparity_px),
                  static_cast<float>(f.y + errors.rows_px(f.x, f.y)), slanted(f), SearchAxes::row_only, patch);
    if (fit.ok) f.raw_disparity_px = f.x - static_cast<double>(fit.x);
  }
  compensate(errors.check, frame);
}

void Tracker::compensate(const SelfCheck& check, Frame& frame) const {
  for (Feature& f : frame.features) {
    const double d = f.raw_disparity_px - check.disparity_error_px(f.x, f.y) - frame.shift_px;
    f.disparity_px = std::max(d, kMinDisparity_px - model_.doffs_px);
    f.point = model_.triangulate(f.x, f.y, f.disparity_px);
  }
}

void Tracker::track(const Frame& reference, const Frame& current, const RigidTransform& T_ref_cur, int reference_index,
                    const FeatureRange& range, PatchSize size, const ViewErrors& errors,
                    std::vector<Observation>& observations) const {
  const RigidTransform T_cur_ref = T_ref_cur.inverse();
  const PatchParams& patch = size == PatchSize::usual ? patch_ : large_patch_;
  const double reach = patch.radius;
  SurfacePatch expected;
  Observation o;
  for (std::size_t i = range.first; i < std::min(range.last, reference.features.size()); ++i) {
    const Feature& f = reference.features[i];
    RigidTransform T = T_cur_ref;
    if (shutter_.rolls()) {
      T = between_rows(model_, shutter_, f, f.disparity_px, T_cur_ref, errors.reference_velocity, errors.velocity);
    }
    if (!surface_patch(model_, f, f.disparity_px, T, reach, expected)) continue;
    if (!(expected.u >= reach && expected.v >= reach && expected.u <= model_.width - 1 - reach &&
          expected.v <= model_.height - 1 - reach)) {
      continue;
    }
    if (!(expected.area > 1.0 / kMostWarp && expected.area < kMostWarp)) continue;
    if (!find(reference, current, f, expected, patch, errors, o)) continue;
    o.reference = reference_index;
    o.feature = static_cast<int>(i);
    observations.push_back(o);
  }
}

// The feature's patch in the current left image, then that place's in the right one.
bool Tracker::find(const Frame& reference, const Frame& current, const Feature& f, const SurfacePatch& expected,
                   const PatchParams& patch, const ViewErrors& errors, Observation& o) const {
  Template t;
  if (!cut_template(reference.left.cview(), static_cast<float>(f.x), static_cast<float>(f.y), patch.radius, t)) {
    return false;
  }
  const PatchFit fit = fit_patch(t, current.left.cview(), static_cast<float>(expected.u),
                                 static_cast<float>(expected.v), expected.warp, SearchAxes::both, patch);
  if (!fit.ok) return false;
  if (!cut_template(current.left.cview(), fit.x, fit.y, patch.radius, t)) return false;
  PatchParams stereo_patch = patch;
  stereo_patch.max_shift_px = kStereoShift_px;
  const double error_d = errors.disparity_px(fit.x, fit.y);
  const float row = fit.y + static_cast<float>(errors.rows_px(fit.x, fit.y));
  const PatchFit stereo =
      fit_patch(t, current.right.cview(), fit.x - static_cast<float>(expected.disparity_px + error_d), row,
                expected.to_right, SearchAxes::row_only, stereo_patch);
  if (!stereo.ok) return false;
  // The frame's own common error stays in: the motion is solved for together with it.
  const double d = static_cast<double>(fit.x) - static_cast<double>(stereo.x) - (error_d - errors.shift_px);
  if (d - errors.shift_px + model_.doffs_px < kMinDisparity_px || d + model_.doffs_px < kMinDisparity_px) return false;
  o = {};
  o.uvd_ref = {static_cast<double>(f.x), static_cast<double>(f.y), f.disparity_px};
  o.uvd_cur = {fit.x, fit.y, d};
  if (shutter_.rolls()) {
    o.uvd_ref = shutter_.at_stamp(model_, errors.reference_velocity, o.uvd_ref);
    o.uvd_cur = shutter_.at_stamp(model_, errors.velocity, o.uvd_cur);
  }
  o.brighter = fit.brighter;
  o.change = 1.0F - fit.correlation;
  o.difference = 1.0F - stereo.correlation;
  return true;
}

}  // namespace cliquevo::vo
