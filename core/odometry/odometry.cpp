// SPDX-License-Identifier: BSD-3-Clause
#include "core/odometry/odometry.h"

#include <string>
#include <utility>

#include "stereo/dense_stereo.h"
#include "stereo/rectify.h"
#include "stereo/usable_area.h"

namespace cliquevo {

namespace {

using stereo::CameraSide;
using View = ImageView<const std::uint8_t>;

std::string size_text(int width, int height) { return std::to_string(width) + "x" + std::to_string(height); }

Result<void> check_image(View image, const char* name, const CameraCalibration& wanted) {
  const std::string size = size_text(wanted.width, wanted.height);
  if (image.empty()) return Error{"unusable frame", std::string(name) + " is missing", "give " + size + " grey pixels"};
  if (!image.same_size(wanted.width, wanted.height)) {
    return Error{"unusable frame", std::string(name) + " has " + size_text(image.width, image.height) + " px",
                 "give images of " + size + " px, as the calibration"};
  }
  if (image.stride < image.width) {
    return Error{"unusable frame", std::string(name) + " has rows closer than its width", "give the row's true stride"};
  }
  return {};
}

Result<void> check_mask(View mask, const char* name, const CameraCalibration& wanted) {
  return mask.empty() ? Result<void>() : check_image(mask, name, wanted);
}

CameraCalibration pinhole(const StereoModel& model, double doffs_px) {
  CameraCalibration out;
  out.width = model.width;
  out.height = model.height;
  out.fx_px = model.fx_px;
  out.fy_px = model.fy_px;
  out.cx_px = model.cx_px + doffs_px;
  out.cy_px = model.cy_px;
  return out;
}

// Rectified images have the rectified pair's size, whatever the raw ones' was.
CameraCalibration input_camera(const CameraCalibration& camera, const StereoCalibration& calibration) {
  CameraCalibration out = camera;
  if (calibration.rectified && calibration.prescribed) {
    out.width = calibration.prescribed->model.width;
    out.height = calibration.prescribed->model.height;
  }
  return out;
}

}  // namespace

struct Odometry::Impl {
  CameraCalibration left_camera;
  CameraCalibration right_camera;
  stereo::Rectifier rectifier;
  stereo::DenseStereo dense;
  vo::VisualOdometry odometry;
  Image<std::uint8_t> right_area;  // empty = all of it may be used
  Image<std::uint8_t> left;        // rectified; not used where the input is
  Image<std::uint8_t> right;
  Image<std::uint8_t> filtered_left;
  Image<std::int16_t> disparity;

  void prepare() {
    const StereoModel& model = rectifier.model();
    for (Image<std::uint8_t>* image : {&left, &right, &filtered_left}) {
      image->resize(model.width, model.height);
      image->fill(0);
    }
    disparity.resize(model.width, model.height);
    disparity.fill(kUnknownDisparity);
  }

  Result<void> rectify(View& raw_left, View& raw_right) {
    if (rectifier.is_identity()) return {};
    if (auto ok = rectifier.rectify(CameraSide::left, raw_left, left.view()); !ok) return ok;
    if (auto ok = rectifier.rectify(CameraSide::right, raw_right, right.view()); !ok) return ok;
    raw_left = left.cview();
    raw_right = right.cview();
    return {};
  }
};

Odometry::Odometry(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Odometry::Odometry(Odometry&&) noexcept = default;
Odometry& Odometry::operator=(Odometry&&) noexcept = default;
Odometry::~Odometry() = default;

Result<Odometry> Odometry::make(const StereoModel& model, const OdometryParams& params, const OdometryMasks& masks) {
  if (auto ok = model.check(); !ok) return ok.error();
  StereoCalibration calibration;
  calibration.left = pinhole(model, 0.0);
  calibration.right = pinhole(model, model.doffs_px);
  calibration.T_right_left.t.x() = -model.baseline_m;
  calibration.readout_s = model.readout_s;
  calibration.rectified = true;
  calibration.prescribed = PrescribedRectification{};
  calibration.prescribed->model = model;
  return make(calibration, params, masks);
}

Result<Odometry> Odometry::make(const StereoCalibration& calibration, const OdometryParams& params,
                                const OdometryMasks& masks) {
  auto rectifier = stereo::Rectifier::make(calibration, params.rectify);
  if (!rectifier) return rectifier.error();
  const StereoModel& model = rectifier->model();
  auto dense = stereo::DenseStereo::make(params.stereo, model.width, model.height);
  if (!dense) return dense.error();
  auto odometry = vo::VisualOdometry::make(model, params.odometry);
  if (!odometry) return odometry.error();

  const CameraCalibration left_camera = input_camera(calibration.left, calibration);
  const CameraCalibration right_camera = input_camera(calibration.right, calibration);
  if (auto ok = check_mask(masks.left, "the left mask", left_camera); !ok) return ok.error();
  if (auto ok = check_mask(masks.right, "the right mask", right_camera); !ok) return ok.error();
  auto left_area = stereo::usable_area(*rectifier, CameraSide::left, masks.left, left_camera);
  if (!left_area) return left_area.error();
  if (!left_area->empty()) {
    if (auto ok = odometry->set_mask(left_area->cview()); !ok) return ok.error();
  }
  auto right_area = stereo::usable_area(*rectifier, CameraSide::right, masks.right, right_camera);
  if (!right_area) return right_area.error();

  auto impl = std::make_unique<Impl>(Impl{left_camera,
                                          right_camera,
                                          std::move(*rectifier),
                                          std::move(*dense),
                                          std::move(*odometry),
                                          std::move(*right_area),
                                          {},
                                          {},
                                          {},
                                          {}});
  impl->prepare();
  return Odometry(std::move(impl));
}

Result<vo::Estimate> Odometry::step(View left, View right, TimestampNs stamp_ns) {
  Impl& my = *impl_;
  if (auto ok = check_image(left, "the left image", my.left_camera); !ok) return ok.error();
  if (auto ok = check_image(right, "the right image", my.right_camera); !ok) return ok.error();
  if (auto ok = my.rectify(left, right); !ok) return ok.error();
  if (auto ok = my.dense.compute(left, right, my.filtered_left.view(), my.disparity.view()); !ok) return ok.error();
  if (!my.right_area.empty()) stereo::drop_unusable(my.right_area.cview(), my.disparity.view());
  auto done = my.odometry.process({stamp_ns, left, right, my.filtered_left.cview(), my.disparity.cview()});
  if (!done) return done.error();
  return my.odometry.estimate();
}

const vo::Estimate& Odometry::estimate() const { return impl_->odometry.estimate(); }
const vo::Movers& Odometry::movers() const { return impl_->odometry.movers(); }
void Odometry::list_features(std::vector<vo::SeenFeature>& out) const { impl_->odometry.list_features(out); }
ImageView<const std::int16_t> Odometry::disparity() const { return impl_->disparity.cview(); }
const StereoModel& Odometry::model() const { return impl_->rectifier.model(); }
int Odometry::left_width() const { return impl_->left_camera.width; }
int Odometry::left_height() const { return impl_->left_camera.height; }
int Odometry::right_width() const { return impl_->right_camera.width; }
int Odometry::right_height() const { return impl_->right_camera.height; }
void Odometry::reset() { impl_->odometry.reset(); }

}  // namespace cliquevo
