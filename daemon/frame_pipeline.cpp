// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/frame_pipeline.h"

#include <string>
#include <utility>

namespace cliquevo::daemon {

namespace {

using drivers::SourceInfo;
using drivers::StereoPair;
using stereo::Eye;

// Where the rectified eye shows anything that may be used: not the vehicle's own parts, not beyond the raw image's
// edge.
Result<Image<std::uint8_t>> usable_area(const stereo::Rectifier& rectifier, Eye eye, ImageView<const std::uint8_t> mask,
                                        const CameraCalibration& raw) {
  Image<std::uint8_t> everything;
  if (mask.empty()) {
    everything.resize(raw.width, raw.height);
    everything.fill(255);
    mask = everything.cview();
  }
  Image<std::uint8_t> area(rectifier.model().width, rectifier.model().height);
  if (auto ok = rectifier.rectify_mask(eye, mask, area.view()); !ok) return ok.error();
  return area;
}

bool excludes_anything(ImageView<const std::uint8_t> mask) {
  for (int y = 0; y < mask.height; ++y) {
    for (int x = 0; x < mask.width; ++x) {
      if (mask(x, y) == 0) return true;
    }
  }
  return false;
}

// Drops disparities whose right pixel must not be used: no feature, then, rests on it.
void apply_right_mask(ImageView<const std::uint8_t> mask, ImageView<std::int16_t> disparity) {
  constexpr int kHalf = kDisparityScale / 2;
  for (int y = 0; y < disparity.height; ++y) {
    std::int16_t* d = disparity.row(y);
    const std::uint8_t* usable = mask.row(y);
    for (int x = 0; x < disparity.width; ++x) {
      if (d[x] == kUnknownDisparity) continue;
      const int right_x = x - ((d[x] + kHalf) >> 4);
      if (right_x >= 0 && right_x < disparity.width && usable[right_x] == 0) d[x] = kUnknownDisparity;
    }
  }
}

Error wrong_size(const char* eye, const StereoPair& pair, int width, int height, const CameraCalibration& wanted) {
  return {std::string(eye) + " image of another size", "pair " + std::to_string(pair.index),
          std::to_string(width) + "x" + std::to_string(height) + " where the calibration is for " +
              std::to_string(wanted.width) + "x" + std::to_string(wanted.height) + ": give images of that size"};
}

}  // namespace

struct FramePipeline::Impl {
  StereoCalibration calibration;
  stereo::Rectifier rectifier;
  stereo::DenseStereo stereo;
  vo::VisualOdometry odometry;
  Image<std::uint8_t> right_mask;  // empty = all of it is usable
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
  Image<std::uint8_t> filtered_left;
  Image<std::int16_t> disparity;
  StageTimes times;
};

FramePipeline::FramePipeline(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
FramePipeline::FramePipeline(FramePipeline&&) noexcept = default;
FramePipeline& FramePipeline::operator=(FramePipeline&&) noexcept = default;
FramePipeline::~FramePipeline() = default;

Result<FramePipeline> FramePipeline::make(const PipelineParams& params, const SourceInfo& source) {
  auto rectifier = stereo::Rectifier::make(source.calibration);
  if (!rectifier) return rectifier.error();
  const StereoModel model = rectifier->model();
  auto dense = stereo::DenseStereo::make(params.stereo, model.width, model.height);
  if (!dense) return dense.error();
  auto odometry = vo::VisualOdometry::make(model, params.odometry);
  if (!odometry) return odometry.error();

  const StereoCalibration& calibration = source.calibration;
  auto left_area = usable_area(*rectifier, Eye::left, source.left_mask.cview(), calibration.left);
  if (!left_area) return left_area.error();
  auto right_area = usable_area(*rectifier, Eye::right, source.right_mask.cview(), calibration.right);
  if (!right_area) return right_area.error();
  if (excludes_anything(left_area->cview())) {
    if (auto ok = odometry->set_mask(left_area->cview()); !ok) return ok.error();
  }

  auto impl = std::make_unique<Impl>(
      Impl{calibration, std::move(*rectifier), std::move(*dense), std::move(*odometry), {}, {}, {}, {}, {}, {}});
  if (excludes_anything(right_area->cview())) impl->right_mask = std::move(*right_area);
  impl->left.resize(model.width, model.height);
  impl->right.resize(model.width, model.height);
  impl->filtered_left.resize(model.width, model.height);
  impl->disparity.resize(model.width, model.height);
  return FramePipeline(std::move(impl));
}

Result<void> FramePipeline::process(const StereoPair& pair) {
  Impl& p = *impl_;
  const Image<std::uint8_t>& left = pair.left;
  const Image<std::uint8_t>& right = pair.right;
  if (!left.cview().same_size(p.calibration.left.width, p.calibration.left.height)) {
    return wrong_size("left", pair, left.width(), left.height(), p.calibration.left);
  }
  if (!right.cview().same_size(p.calibration.right.width, p.calibration.right.height)) {
    return wrong_size("right", pair, right.width(), right.height(), p.calibration.right);
  }

  const std::int64_t begin = monotonic_ns();
  if (auto ok = p.rectifier.rectify(Eye::left, left.cview(), p.left.view()); !ok) return ok;
  if (auto ok = p.rectifier.rectify(Eye::right, right.cview(), p.right.view()); !ok) return ok;
  const std::int64_t rectified = monotonic_ns();
  if (auto ok = p.stereo.compute(p.left.cview(), p.right.cview(), p.filtered_left.view(), p.disparity.view()); !ok) {
    return ok;
  }
  if (!p.right_mask.empty()) apply_right_mask(p.right_mask.cview(), p.disparity.view());
  const std::int64_t matched = monotonic_ns();
  if (auto ok = p.odometry.process(
          {pair.stamp_ns, p.left.cview(), p.right.cview(), p.filtered_left.cview(), p.disparity.cview()});
      !ok) {
    return ok;
  }
  p.times = {rectified - begin, matched - rectified, monotonic_ns() - matched};
  return {};
}

const vo::Estimate& FramePipeline::estimate() const { return impl_->odometry.estimate(); }
const StageTimes& FramePipeline::times() const { return impl_->times; }
const StereoModel& FramePipeline::model() const { return impl_->rectifier.model(); }
ImageView<const std::uint8_t> FramePipeline::rectified_left() const { return impl_->left.cview(); }
ImageView<const std::uint8_t> FramePipeline::rectified_right() const { return impl_->right.cview(); }
ImageView<const std::int16_t> FramePipeline::disparity() const { return impl_->disparity.cview(); }

}  // namespace cliquevo::daemon
