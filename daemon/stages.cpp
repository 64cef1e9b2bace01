// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/stages.h"

#include <utility>

namespace cliquevo::daemon {

StereoStage::StereoStage(stereo::Rectifier rectifier, stereo::DenseStereo dense)
    : rectifier_(std::move(rectifier)), dense_(std::move(dense)) {}

Result<StereoStage> StereoStage::make(const stereo::StereoParams& params, const drivers::SourceInfo& source) {
  auto rectifier = stereo::Rectifier::make(source.calibration);
  if (!rectifier) return rectifier.error();
  const StereoModel& model = rectifier->model();
  auto dense = stereo::DenseStereo::make(params, model.width, model.height);
  if (!dense) return dense.error();
  return StereoStage(std::move(*rectifier), std::move(*dense));
}

Result<Image<std::uint8_t>> StereoStage::rectified_mask(const drivers::SourceInfo& source) const {
  Image<std::uint8_t> mask;
  if (source.left_mask.empty()) return mask;
  mask.resize(model().width, model().height);
  if (const auto ok = rectifier_.rectify_mask(stereo::Eye::left, source.left_mask.view(), mask.view()); !ok) {
    return ok.error();
  }
  return mask;
}

void StereoStage::prepare(FrameSlot& slot) const {
  const StereoModel& m = model();
  for (Image<std::uint8_t>* image : {&slot.left, &slot.right, &slot.filtered_left}) {
    image->resize(m.width, m.height);
    image->fill(0);
  }
  slot.disparity.resize(m.width, m.height);
  slot.disparity.fill(kUnknownDisparity);
}

Result<void> StereoStage::run(FrameSlot& slot) {
  const std::int64_t begin_ns = monotonic_ns();
  if (auto ok = rectifier_.rectify(stereo::Eye::left, slot.pair.left.cview(), slot.left.view()); !ok) return ok;
  if (auto ok = rectifier_.rectify(stereo::Eye::right, slot.pair.right.cview(), slot.right.view()); !ok) return ok;
  const std::int64_t rectified_ns = monotonic_ns();
  if (auto ok = dense_.compute(slot.left.cview(), slot.right.cview(), slot.filtered_left.view(), slot.disparity.view());
      !ok) {
    return ok;
  }
  slot.times.rectify_ns = rectified_ns - begin_ns;
  slot.times.stereo_ns = monotonic_ns() - rectified_ns;
  return {};
}

OdometryStage::OdometryStage(vo::VisualOdometry odometry) : odometry_(std::move(odometry)) {}

Result<OdometryStage> OdometryStage::make(const vo::VoParams& params, const StereoModel& model,
                                          ImageView<const std::uint8_t> left_mask) {
  auto odometry = vo::VisualOdometry::make(model, params);
  if (!odometry) return odometry.error();
  if (!left_mask.empty()) {
    if (const auto ok = odometry->set_mask(left_mask); !ok) return ok.error();
  }
  return OdometryStage(std::move(*odometry));
}

Result<void> OdometryStage::run(FrameSlot& slot) {
  const std::int64_t begin_ns = monotonic_ns();
  vo::FrameInput input;
  input.stamp_ns = slot.pair.stamp_ns;
  input.left = slot.left.cview();
  input.right = slot.right.cview();
  input.filtered_left = slot.filtered_left.cview();
  input.disparity = slot.disparity.cview();
  auto done = odometry_.process(input);
  slot.times.odometry_ns = monotonic_ns() - begin_ns;
  return done;
}

}  // namespace cliquevo::daemon
