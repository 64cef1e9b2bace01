// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/image_consistency.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include "core/vo/tracking.h"

namespace cliquevo::vo {

namespace {

constexpr int kCells = 120;            // at most, about
constexpr int kLeastSide = 16;         // px, of a cell
constexpr int kTestRadius = 7;         // half side of a patch: larger than a feature's, for weakly textured ground
constexpr int kIterations = 5;         // of the search: to a tenth of a pixel is enough
constexpr int kMostVotes = 2;          // of a cell's patches
constexpr double kNearby = 2.5;        // px, a patch found so near to its place agrees
constexpr double kMostChange = 2.0;    // of a patch's area: seen too differently to compare
constexpr double kSameDepth = 0.1;     // share of the disparity, and at least ...
constexpr double kSameDepth_px = 1.5;  // ... this: beyond, something else is seen there
// Correlations: of the left and the right patch, from which a patch may vote (noise lowers this one as well) ...
constexpr float kSeenByBoth = 0.7F;
constexpr float kAlike = 0.7F;          // ... with the patch of the other frame, as a share of that: agrees ...
constexpr float kUnlike = 0.5F;         // ... or contradicts
constexpr double kClippedShare = 0.05;  // of a patch's pixels at either end of the scale: it is not judged
// A repeated pattern (railings, bricks) is found in several places, in space and in depth: a patch that correlates
// nearly as well with its own surroundings as with its image in the other camera proves nothing.
constexpr float kRepeated = 0.9F;
constexpr double kNearSelf = 0.5;     // of the patch's side: nearer, every patch resembles itself
constexpr double kRepeatReach = 3.0;  // sides of the patch along the row, where stereo matching looks

// Gradients around a place, in the direction in which there are fewer.
int texture_at(ImageView<const std::uint8_t> image, int x, int y) {
  int gx = 0, gy = 0;
  for (int dy = -4; dy <= 4; dy += 2) {
    const std::uint8_t* row = image.row(y + dy) + x;
    for (int dx = -4; dx <= 4; dx += 2) {
      gx += std::abs(row[dx + 1] - row[dx - 1]);
      gy += std::abs(row[dx + image.stride] - row[dx - image.stride]);
    }
  }
  return std::min(gx, gy);
}

// Whether a part of the patch there is burnt out or black: what was seen cannot be seen there.
bool clipped(ImageView<const std::uint8_t> image, int x, int y) {
  int n = 0;
  for (int dy = -kTestRadius; dy <= kTestRadius; ++dy) {
    const std::uint8_t* row = image.row(y + dy) + x;
    for (int dx = -kTestRadius; dx <= kTestRadius; ++dx) n += row[dx] == 0 || row[dx] == 255 ? 1 : 0;
  }
  return n > kClippedShare * (2 * kTestRadius + 1) * (2 * kTestRadius + 1);
}

// A patch less its mean and its slopes, which are what a glow or a shadow's edge adds.
class Detail {
 public:
  template <class Sample>
  explicit Detail(Sample&& sample) {
    double mean = 0.0, along_x = 0.0, along_y = 0.0, squares = 0.0;
    each([&](int dx, int dy, double& value) {
      value = sample(dx, dy);
      mean += value;
      along_x += value * dx;
      along_y += value * dy;
      squares += dx * dx;
    });
    mean /= static_cast<double>(values_.size());
    each([&](int dx, int dy, double& value) { value -= mean + (along_x * dx + along_y * dy) / squares; });
  }
  double correlation(const Detail& other) const {
    double both = 0.0, here = 0.0, there = 0.0;
    for (std::size_t i = 0; i < values_.size(); ++i) {
      both += values_[i] * other.values_[i];
      here += values_[i] * values_[i];
      there += other.values_[i] * other.values_[i];
    }
    return here > 0.0 && there > 0.0 ? both / std::sqrt(here * there) : 0.0;
  }

 private:
  template <class F>
  void each(F&& f) {
    std::size_t i = 0;
    for (int dy = -kTestRadius; dy <= kTestRadius; ++dy) {
      for (int dx = -kTestRadius; dx <= kTestRadius; ++dx) f(dx, dy, values_[i++]);
    }
  }
  static constexpr std::size_t kSide = 2 * kTestRadius + 1;
  std::array<double, kSide * kSide> values_{};
};

// Between a feature's patch and the image where it is expected.
double detail_correlation(ImageView<const std::uint8_t> reference, const Feature& f,
                          ImageView<const std::uint8_t> image, const SurfacePatch& expected) {
  const Detail then([&](int dx, int dy) { return static_cast<double>(reference(f.x + dx, f.y + dy)); });
  const Detail now([&](int dx, int dy) {
    const double right = dx, down = dy;
    const double u = expected.u + expected.warp.xx * right + expected.warp.xy * down;
    const double v = expected.v + expected.warp.yx * right + expected.warp.yy * down;
    const int x = std::clamp(static_cast<int>(u), 0, image.width - 2);
    const int y = std::clamp(static_cast<int>(v), 0, image.height - 2);
    const double fx = u - x, fy = v - y;
    return (1.0 - fy) * ((1.0 - fx) * image(x, y) + fx * image(x + 1, y)) +
           fy * ((1.0 - fx) * image(x, y + 1) + fx * image(x + 1, y + 1));
  });
  return then.correlation(now);
}

}  // namespace

ImageConsistency::ImageConsistency(const StereoModel& model) : model_(model), shutter_(model) {
  patch_.radius = kTestRadius;
  patch_.iterations = kIterations;
  patch_.max_residual = 255.0;  // correlation decides
  patch_.max_shift_px = kNearby;
  const double area = static_cast<double>(model.width) * model.height;
  side_px_ = std::max(kLeastSide, static_cast<int>(std::ceil(std::sqrt(area / kCells))));
  across_ = (model.width + side_px_ - 1) / side_px_;
  down_ = (model.height + side_px_ - 1) / side_px_;
  const std::size_t cells = static_cast<std::size_t>(across_) * static_cast<std::size_t>(down_);
  has_feature_.resize(cells);
  tested_.resize(cells);
  votes_.resize(cells);
}

void ImageConsistency::choose_test_patches(ImageView<const std::int16_t> disparity, Frame& frame) {
  frame.test_patches.clear();
  frame.test_patches.reserve(has_feature_.size());  // the first time only
  std::fill(has_feature_.begin(), has_feature_.end(), 0);
  for (const Feature& f : frame.features) has_feature_[cell_of(f.x, f.y)] = 1;
  const ImageView<const std::uint8_t> image = frame.left.cview();
  const int step = std::max(4, side_px_ / 8);
  for (int top = 0; top < model_.height; top += side_px_) {
    for (int left = 0; left < model_.width; left += side_px_) {
      if (has_feature_[cell_of(left, top)] != 0) continue;
      Feature best;
      const int right = std::min(left + side_px_, model_.width - kFeatureMargin);
      const int bottom = std::min(top + side_px_, model_.height - kFeatureMargin);
      for (int y = std::max(top, kFeatureMargin); y < bottom; y += step) {
        for (int x = std::max(left, kFeatureMargin); x < right; x += step) {
          const std::int16_t d = disparity(x, y);
          if (d == kUnknownDisparity) continue;
          const int texture = texture_at(image, x, y);
          if (texture <= best.score) continue;
          best.x = x;
          best.y = y;
          best.score = texture;
          best.disparity_px = d / static_cast<double>(kDisparityScale);
        }
      }
      if (best.score == 0) continue;
      best.raw_disparity_px = best.disparity_px;
      measure_slant(disparity, best);
      frame.test_patches.push_back(best);
    }
  }
}

ImageConsistency::Vote ImageConsistency::test_patch(const Feature& f, const Frame& reference, const Frame& current,
                                                    ImageView<const std::int16_t> disparity,
                                                    const RigidTransform& T_cur_ref, const ViewErrors& errors,
                                                    Contradicts which) const {
  const double d = f.raw_disparity_px - errors.check.disparity_error_px(f.x, f.y) - reference.shift_px;
  if (d + model_.doffs_px < kMinDisparity_px) return Vote::none;
  SurfacePatch expected;
  RigidTransform T = T_cur_ref;
  if (shutter_.rolls()) {
    T = between_rows(model_, shutter_, f, d, T_cur_ref, errors.reference_velocity, errors.velocity);
  }
  if (!surface_patch(model_, f, d, T, kTestRadius, expected)) return Vote::none;
  const double reach = kTestRadius + 4;
  if (!(expected.u >= reach && expected.v >= reach && expected.u < model_.width - reach &&
        expected.v < model_.height - reach)) {
    return Vote::none;
  }
  if (!(expected.area > 1.0 / kMostChange && expected.area < kMostChange)) return Vote::none;
  // Hidden by something else, or not known: then the place does not vote.
  const std::int16_t there =
      disparity(static_cast<int>(std::lround(expected.u)), static_cast<int>(std::lround(expected.v)));
  if (there == kUnknownDisparity) return Vote::none;
  const double seen = there / static_cast<double>(kDisparityScale) - errors.disparity_px(expected.u, expected.v);
  if (std::abs(seen - expected.disparity_px) > std::max(kSameDepth_px, kSameDepth * expected.disparity_px)) {
    return Vote::none;
  }
  Template t;
  if (!cut_template(reference.left.cview(), static_cast<float>(f.x), static_cast<float>(f.y), patch_.radius, t)) {
    return Vote::none;
  }
  const PatchFit moved = fit_patch(t, current.left.cview(), static_cast<float>(expected.u),
                                   static_cast<float>(expected.v), expected.warp, SearchAxes::both, patch_);
  if (moved.correlation > kAlike) return Vote::agrees;
  if (clipped(current.left.cview(), static_cast<int>(std::lround(expected.u)),
              static_cast<int>(std::lround(expected.v)))) {
    return Vote::none;
  }
  // Not found: it counts only where both cameras see it alike.
  Warp to_right;
  to_right.xx = static_cast<float>(1.0 - f.disparity_dx);
  to_right.xy = static_cast<float>(-f.disparity_dy);
  const PatchFit both =
      fit_patch(t, reference.right.cview(), static_cast<float>(f.x - f.raw_disparity_px),
                static_cast<float>(f.y + errors.check.vertical_error_px(f.x, f.y)), to_right, SearchAxes::both, patch_);
  if (both.correlation < kSeenByBoth) return Vote::none;
  if (moved.correlation > kAlike * both.correlation) return Vote::agrees;
  if (moved.correlation >= kUnlike * both.correlation) return Vote::none;
  if (detail_correlation(reference.left.cview(), f, current.left.cview(), expected) >= kUnlike * both.correlation) {
    return Vote::none;
  }
  if (which == Contradicts::any) return Vote::contradicts;
  const bool unique = !repeated(t, f, reference, kRepeated * both.correlation, expected.u - f.x, expected.v - f.y);
  return unique ? Vote::contradicts : Vote::none;
}

// Whether the patch is seen again nearby, with at least this correlation: along its row, where a wrong depth would come
// from, or along the way (du, dv) that it would have moved.
bool ImageConsistency::repeated(const Template& t, const Feature& f, const Frame& reference, float correlation,
                                double du, double dv) const {
  PatchParams once = patch_;
  once.iterations = 1;  // only the correlation there
  const double side = 2.0 * kTestRadius + 1.0;
  const auto along = [&](double dx, double dy, double length) {
    const double nearest = kNearSelf * side;
    for (int step = 0; nearest + step <= length; ++step) {
      for (const double way : {nearest + step, -nearest - step}) {
        const PatchFit there = fit_patch(t, reference.left.cview(), static_cast<float>(f.x + way * dx),
                                         static_cast<float>(f.y + way * dy), {}, SearchAxes::both, once);
        if (there.correlation > correlation) return true;
      }
    }
    return false;
  };
  if (along(1.0, 0.0, kRepeatReach * side)) return true;
  const double moved = std::hypot(du, dv);
  return moved > kNearSelf * side && along(du / moved, dv / moved, moved + 0.5 * side);
}

CellVotes ImageConsistency::count(const Frame& reference, const Frame& current, ImageView<const std::int16_t> disparity,
                                  const RigidTransform& T_ref_cur, const ViewErrors& errors,
                                  const std::vector<Observation>& observations, Contradicts which) {
  std::fill(votes_.begin(), votes_.end(), Vote::none);
  for (const Observation& o : observations) {
    if (o.reference != 0 || !o.inlier) continue;
    const Feature& f = reference.features[static_cast<std::size_t>(o.feature)];
    votes_[cell_of(f.x, f.y)] = Vote::agrees;
  }
  CellVotes out;
  out.cells = static_cast<int>(votes_.size());
  for (const Vote v : votes_) out.inliers += v == Vote::agrees ? 1 : 0;
  const RigidTransform T_cur_ref = T_ref_cur.inverse();
  const auto collect_votes = [&](const std::vector<Feature>& places) {
    for (const Feature& place : places) {
      const std::size_t cell = cell_of(place.x, place.y);
      if (votes_[cell] == Vote::agrees || tested_[cell] >= kMostVotes) continue;
      const Vote vote = test_patch(place, reference, current, disparity, T_cur_ref, errors, which);
      if (vote == Vote::none) continue;
      ++tested_[cell];
      votes_[cell] = std::max(votes_[cell], vote);
    }
  };
  std::fill(tested_.begin(), tested_.end(), 0);
  collect_votes(reference.features);  // the best of each cell come first
  collect_votes(reference.test_patches);
  for (const Vote v : votes_) {
    out.agree += v == Vote::agrees ? 1 : 0;
    out.contradict += v == Vote::contradicts ? 1 : 0;
  }
  return out;
}

}  // namespace cliquevo::vo
