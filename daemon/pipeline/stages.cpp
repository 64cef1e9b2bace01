// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/stages.h"

#include <string>
#include <utility>

#include "stereo/usable_area.h"

namespace cliquevo::daemon {

namespace {

using drivers::SourceInfo;
using drivers::StereoPair;
using stereo::CameraSide;

Error wrong_size(const char* side, std::int64_t index, const Image<std::uint8_t>& image,
                 const CameraCalibration& wanted) {
  return {std::string(side) + " image of another size", "pair " + std::to_string(index),
          std::to_string(image.width()) + "x" + std::to_string(image.height()) + " where the calibration is for " +
              std::to_string(wanted.width) + "x" + std::to_string(wanted.height) + ": give images of that size"};
}

}  // namespace

StereoStage::StereoStage(const StereoCalibration& calibration, stereo::Rectifier rectifier, stereo::DenseStereo dense)
    : calibration_(calibration), rectifier_(std::move(rectifier)), dense_(std::move(dense)) {}

Result<StereoStage> StereoStage::make(const stereo::StereoParams& params, const SourceInfo& source,
                                      const stereo::RectifyParams& rectify) {
  auto rectifier = stereo::Rectifier::make(source.calibration, rectify);
  if (!rectifier) return rectifier.error();
  auto dense = stereo::DenseStereo::make(params, rectifier->model().width, rectifier->model().height);
  if (!dense) return dense.error();
  auto right_area =
      stereo::usable_area(*rectifier, CameraSide::right, source.right_mask.cview(), source.calibration.right);
  if (!right_area) return right_area.error();
  StereoStage stage(source.calibration, std::move(*rectifier), std::move(*dense));
  stage.right_mask_ = std::move(*right_area);
  return stage;
}

void StereoStage::prepare(StereoFrame& frame) const {
  for (Image<std::uint8_t>* image : {&frame.left, &frame.right, &frame.filtered_left}) {
    image->resize(model().width, model().height);
    image->fill(0);  // touched: the pages are there
  }
  frame.disparity.resize(model().width, model().height);
  frame.disparity.fill(kUnknownDisparity);
}

Result<void> StereoStage::run(const StereoPair& pair, StereoFrame& frame) {
  const CameraCalibration& l = calibration_.left;
  const CameraCalibration& r = calibration_.right;
  if (!pair.left.cview().same_size(l.width, l.height)) return wrong_size("left", pair.index, pair.left, l);
  if (!pair.right.cview().same_size(r.width, r.height)) return wrong_size("right", pair.index, pair.right, r);

  const std::int64_t begin_ns = monotonic_ns();
  if (auto ok = rectifier_.rectify(CameraSide::left, pair.left.cview(), frame.left.view()); !ok) return ok;
  if (auto ok = rectifier_.rectify(CameraSide::right, pair.right.cview(), frame.right.view()); !ok) return ok;
  const std::int64_t rectified_ns = monotonic_ns();
  auto done =
      dense_.compute(frame.left.cview(), frame.right.cview(), frame.filtered_left.view(), frame.disparity.view());
  if (!done) return done;
  if (!right_mask_.empty()) stereo::drop_unusable(right_mask_.cview(), frame.disparity.view());
  frame.times = {rectified_ns - begin_ns, monotonic_ns() - rectified_ns, 0};
  return {};
}

OdometryStage::OdometryStage(vo::VisualOdometry odometry) : odometry_(std::move(odometry)) {}

Result<OdometryStage> OdometryStage::make(const vo::VoParams& params, const SourceInfo& source,
                                          const StereoStage& stereo) {
  auto odometry = vo::VisualOdometry::make(stereo.model(), params);
  if (!odometry) return odometry.error();
  auto area =
      stereo::usable_area(stereo.rectifier(), CameraSide::left, source.left_mask.cview(), source.calibration.left);
  if (!area) return area.error();
  if (!area->empty()) {
    if (auto ok = odometry->set_mask(area->cview()); !ok) return ok.error();
  }
  OdometryStage stage(std::move(*odometry));
  stage.mask_ = std::move(*area);
  return stage;
}

Result<void> OdometryStage::run(TimestampNs stamp_ns, StereoFrame& frame) {
  const std::int64_t begin_ns = monotonic_ns();
  auto done = odometry_.process(
      {stamp_ns, frame.left.cview(), frame.right.cview(), frame.filtered_left.cview(), frame.disparity.cview()});
  frame.times.odometry_ns = monotonic_ns() - begin_ns;
  return done;
}

}  // namespace cliquevo::daemon
