// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/lcm/messages.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>

namespace cliquevo::daemon {

namespace {

void put(const Eigen::Vector3d& v, double (&out)[3]) {
  for (int i = 0; i < 3; ++i) out[i] = v[i];
}

// w x y z with w >= 0: one sign for one rotation.
void put(const Eigen::Matrix3d& R, double (&out)[4]) {
  Eigen::Quaterniond q(R);
  q.normalize();
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  out[0] = sign * q.w();
  out[1] = sign * q.x();
  out[2] = sign * q.y();
  out[3] = sign * q.z();
}

void put(const Matrix6d& M, double (&out)[6][6]) {
  for (int r = 0; r < 6; ++r) {
    for (int c = 0; c < 6; ++c) out[r][c] = M(r, c);
  }
}

Matrix6d sendable(const Matrix6d& covariance) {
  if (covariance.allFinite()) return covariance;
  return Matrix6d::Identity() * kUnknownVariance;
}

// Finite, and a rotation at all: the quaternion of a wreck may be NaN although the wreck is not.
bool usable(const RigidTransform& T) {
  if (!T.is_finite()) return false;
  const double det = T.R.determinant();
  return det > 0.5 && det < 2.0 && T.t.cwiseAbs().maxCoeff() < 1e12;
}

std::int32_t duration_us(std::int64_t ns) {
  constexpr std::int64_t kMax = std::numeric_limits<std::int32_t>::max();
  return static_cast<std::int32_t>(std::clamp<std::int64_t>(ns / 1000, 0, kMax));
}

std::int64_t stamp_us(TimestampNs ns) { return ns == 0 ? 0 : floor_us(ns); }

}  // namespace

MessageBuilder::MessageBuilder(const RigidTransform& T_body_camera)
    : T_body_camera_(T_body_camera),
      T_camera_body_(T_body_camera.inverse()),
      adjoint_body_camera_(adjoint(T_body_camera)),
      odometry_(T_body_camera) {}

void MessageBuilder::build(const PublishedFrame& frame, TimestampNs publish_ns, FrameMessages& out) {
  const vo::Estimate& e = frame.estimate;
  const bool motion_ok = usable(e.T_prev_cur) && usable(e.T_world_camera) && e.covariance.allFinite();
  const bool errors_ok = std::isfinite(e.reprojection_error_px) && std::isfinite(e.eigenvalue_ratio);
  build_delta(e, motion_ok, out.delta);
  build_delta_body(e, out.delta, out.delta_body);
  build_pose(frame, motion_ok, out.pose);
  build_status(frame, publish_ns, out.status);
  odometry_.build(frame, motion_ok, publish_ns, out.odometry);
  out.status.repaired = motion_ok && errors_ok ? 0 : 1;
  const bool moved_as_measured = e.status == vo::Status::valid || e.status == vo::Status::no_data;
  out.status.pose_is_guess = moved_as_measured && motion_ok ? 0 : 1;
}

void MessageBuilder::build_delta(const vo::Estimate& e, bool finite, update_t& out) const {
  const bool valid = e.status == vo::Status::valid && finite;
  const RigidTransform T = valid ? e.T_prev_cur : RigidTransform{};
  out.timestamp = floor_us(e.stamp_ns);
  // Before the first valid frame there is nothing to measure from.
  out.prev_timestamp = e.status == vo::Status::no_data ? out.timestamp : floor_us(e.prev_stamp_ns);
  put(T.t, out.translation);
  put(T.R, out.rotation);
  put(sendable(e.covariance), out.covariance);
  // Readers of this type know 0 to 4 only.
  const bool degenerate =
      e.status == vo::Status::ambiguous || e.status == vo::Status::weak || (e.status == vo::Status::valid && !finite);
  out.estimate_status = degenerate ? update_t::ESTIMATE_DEGENERATE : static_cast<std::int8_t>(e.status);
}

void MessageBuilder::build_delta_body(const vo::Estimate& e, const update_t& delta, update_t& out) const {
  out = delta;
  if (delta.estimate_status == update_t::ESTIMATE_VALID) {
    const RigidTransform T = T_body_camera_ * e.T_prev_cur * T_camera_body_;
    put(T.t, out.translation);
    put(T.R, out.rotation);
  }
  // A perturbation x of the camera's delta on the left is Ad(T_body_camera) x of the body's.
  put(sendable(adjoint_body_camera_ * sendable(e.covariance) * adjoint_body_camera_.transpose()), out.covariance);
}

void MessageBuilder::build_pose(const PublishedFrame& frame, bool finite, pose_t& out) {
  const vo::Estimate& e = frame.estimate;
  SentPose now{RigidTransform{}, e.stamp_ns, frame.resets};
  if (finite) {
    now.T_world_body = (T_body_camera_ * e.T_world_camera * T_camera_body_).normalized();
  } else if (last_) {
    now.T_world_body = last_->T_world_body;
  }

  // Where and when the body was before: at the last valid frame when the motion from there is known, else where the
  // last message put it (a guess then keeps the speed that it was made with).
  std::optional<SentPose> before;
  if (finite && e.status == vo::Status::valid) {
    const RigidTransform T_prev_cur_body = T_body_camera_ * e.T_prev_cur * T_camera_body_;
    before = SentPose{now.T_world_body * T_prev_cur_body.inverse(), e.prev_stamp_ns, frame.resets};
  } else if (finite && e.status != vo::Status::no_data && last_ && last_->resets == frame.resets) {
    before = last_;
  }

  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();
  Eigen::Vector3d rotation_rate = Eigen::Vector3d::Zero();
  if (before && now.stamp_ns > before->stamp_ns) {
    const double dt_s = static_cast<double>(now.stamp_ns - before->stamp_ns) * 1e-9;
    velocity = (now.T_world_body.t - before->T_world_body.t) / dt_s;
    rotation_rate = so3_log(now.T_world_body.R * before->T_world_body.R.transpose()) / dt_s;
  }

  out.utime = floor_us(e.stamp_ns);
  put(now.T_world_body.t, out.pos);
  put(velocity, out.vel);
  put(now.T_world_body.R, out.orientation);
  put(rotation_rate, out.rotation_rate);
  put(Eigen::Vector3d::Zero(), out.accel);
  last_ = now;
}

void MessageBuilder::build_checks(const vo::Estimate& e, status_t& out) {
  constexpr double kMostRatio = 1e9;
  const auto finite = [](double value) { return std::isfinite(value) ? value : 0.0; };
  out.quality = static_cast<std::int8_t>(e.quality);
  out.n_checks = static_cast<std::int32_t>(vo::kChecks);
  out.check_ratio.resize(vo::kChecks);  // the first time only
  for (std::size_t k = 0; k < vo::kChecks; ++k) {
    const double ratio = e.checks[static_cast<vo::Check>(k)].ratio();
    out.check_ratio[k] = std::isnan(ratio) ? kMostRatio : std::clamp(ratio, 0.0, kMostRatio);
  }
  out.checks_failed = static_cast<std::int32_t>(e.checks.failed());
  out.expected_error_px = finite(e.expected_error_px);
  out.disparity_shift_px = finite(e.disparity_shift_px);
  out.disparity_shift_sigma_px = finite(e.disparity_shift_sigma_px);
}

void MessageBuilder::build_status(const PublishedFrame& frame, TimestampNs publish_ns, status_t& out) const {
  const vo::Estimate& e = frame.estimate;
  out.utime = floor_us(e.stamp_ns);
  out.publish_utime = floor_us(publish_ns);
  out.frame = frame.index;
  out.status = static_cast<std::int8_t>(e.status);
  out.features = e.features;
  out.matches = e.matches;
  out.clique = e.clique;
  out.inliers = e.inliers;
  out.reprojection_error_px = std::isfinite(e.reprojection_error_px) ? e.reprojection_error_px : 0.0;
  out.eigenvalue_ratio = std::isfinite(e.eigenvalue_ratio) ? e.eigenvalue_ratio : 0.0;
  build_checks(e, out);
  out.rectify_us = duration_us(frame.times.rectify_ns);
  out.stereo_us = duration_us(frame.times.stereo_ns);
  out.odometry_us = duration_us(frame.times.odometry_ns);
  out.features_us = duration_us(e.times.features_ns);
  out.scores_us = duration_us(e.times.scores_ns);
  out.matches_us = duration_us(e.times.matches_ns);
  out.clique_us = duration_us(e.times.clique_ns);
  out.motion_us = duration_us(e.times.motion_ns);
  out.grabbed_utime = stamp_us(frame.stamps.grabbed_ns);
  out.stereo_begin_utime = stamp_us(frame.stamps.stereo_begin_ns);
  out.stereo_end_utime = stamp_us(frame.stamps.stereo_end_ns);
  out.odometry_begin_utime = stamp_us(frame.stamps.odometry_begin_ns);
  out.odometry_end_utime = stamp_us(frame.stamps.odometry_end_ns);
  out.dropped = frame.dropped;
  out.resets = frame.resets;
  const vo::CalibrationCheck& c = e.calibration;
  const auto measured = [&c](double value) { return c.frames > 0 && std::isfinite(value) ? value : 0.0; };
  out.disparity_offset_px = measured(c.disparity_offset_px);
  out.disparity_offset_sigma_px = measured(c.disparity_offset_sigma_px);
  out.vertical_px = measured(c.vertical_px);
  out.vertical_sigma_px = measured(c.vertical_sigma_px);
  out.calibration_off = c.noticeable() ? 1 : 0;
  out.vehicle_in_view = e.vehicle_part.frames > 0 ? 1 : 0;
}

namespace {

bool finite(const vo::Mover& m) {
  return usable(m.T_prev_cur) && m.covariance.allFinite() && m.centre.allFinite() && m.velocity_m_s.allFinite() &&
         std::isfinite(m.reprojection_error_px);
}

void build_mover(const vo::Mover& m, mover_t& out) {
  out.id = m.id;
  out.frames = m.frames;
  out.of_vehicle = m.of_vehicle ? 1 : 0;
  put(m.centre, out.centre);
  put(m.velocity_m_s, out.velocity);
  put(m.T_prev_cur.t, out.translation);
  put(m.T_prev_cur.R, out.rotation);
  put(m.covariance, out.covariance);
  out.reprojection_error_px = m.reprojection_error_px;
  out.inliers = m.inliers;
  out.num_points = m.points;
  out.pixel.clear();
  out.point.clear();
  for (int i = 0; i < m.points; ++i) {
    const vo::MoverPoint& p = m.point[static_cast<std::size_t>(i)];
    out.pixel.push_back({p.x_px, p.y_px});
    out.point.push_back({p.point.x(), p.point.y(), p.point.z()});
  }
}

}  // namespace

void build_features(const TappedFeatures& tapped, const StereoModel& model, const RigidTransform& T_body_camera,
                    features_t& out) {
  const auto number = [](auto value) { return std::isfinite(value) ? value : decltype(value){0}; };
  out.utime = floor_us(tapped.stamp_ns);
  out.width = model.width;
  out.height = model.height;
  out.fx_px = model.fx_px;
  out.fy_px = model.fy_px;
  out.cx_px = model.cx_px;
  out.cy_px = model.cy_px;
  out.baseline_m = model.baseline_m;
  out.doffs_px = model.doffs_px;
  put(T_body_camera.t, out.camera_translation);
  put(T_body_camera.R, out.camera_rotation);
  out.num_checks = static_cast<std::int32_t>(vo::kChecks);
  out.check_value.resize(vo::kChecks);
  out.check_bound.resize(vo::kChecks);
  for (std::size_t k = 0; k < vo::kChecks; ++k) {
    const vo::Evidence& e = tapped.checks[static_cast<vo::Check>(k)];
    out.check_value[k] = e.applies ? number(e.value) : 0.0;
    out.check_bound[k] = e.applies ? number(e.bound) : 0.0;
  }
  const std::size_t count = tapped.features.size();
  out.num_features = static_cast<std::int32_t>(count);
  for (auto* list : {&out.x, &out.y, &out.from_x, &out.from_y, &out.disparity, &out.error}) list->resize(count);
  out.role.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const vo::SeenFeature& f = tapped.features[i];
    out.x[i] = number(f.x_px);
    out.y[i] = number(f.y_px);
    out.from_x[i] = number(f.from_x_px);
    out.from_y[i] = number(f.from_y_px);
    out.disparity[i] = number(f.disparity_px);
    out.error[i] = number(f.error_px);
    out.role[i] = static_cast<std::int8_t>(f.role);
  }
}

void build_movers(const vo::Movers& movers, movers_t& out) {
  out.utime = floor_us(movers.stamp_ns);
  out.prev_utime = floor_us(movers.prev_stamp_ns);
  out.num_movers = 0;
  out.movers.resize(vo::kMostMovers);  // their memory is kept
  for (int i = 0; i < movers.count; ++i) {
    const vo::Mover& m = movers.mover[static_cast<std::size_t>(i)];
    if (finite(m)) build_mover(m, out.movers[static_cast<std::size_t>(out.num_movers++)]);
  }
}

namespace {

// Room for the bytes of an image, still to be written.
std::uint8_t* begin_image(std::int64_t utime, const ImageView<const std::uint8_t>& like, int bytes_a_pixel,
                          std::size_t bytes, image_t& out) {
  out.utime = utime;
  out.width = like.width;
  out.height = like.height;
  out.row_stride = like.width * bytes_a_pixel;
  out.pixelformat = image_t::PIXEL_FORMAT_GRAY;
  out.size = static_cast<std::int32_t>(bytes);
  out.data.resize(bytes);
  return out.data.data();
}

void put_grey(std::int64_t utime, const ImageView<const std::uint8_t>& grey, image_t& out) {
  const auto pixels = static_cast<std::size_t>(grey.width) * static_cast<std::size_t>(grey.height);
  std::uint8_t* to = begin_image(utime, grey, 1, pixels, out);
  for (int y = 0; y < grey.height; ++y) to = std::copy(grey.row(y), grey.row(y) + grey.width, to);
}

void put_disparity(const TappedImages& images, std::int64_t utime, image_t& out) {
  const ImageView<const std::uint16_t> from = images.disparity.cview();
  const auto pixels = static_cast<std::size_t>(from.width) * static_cast<std::size_t>(from.height);
  std::uint8_t* to = begin_image(utime, images.left.cview(), 2, 2 * pixels, out);
  out.pixelformat = image_t::PIXEL_FORMAT_LE_GRAY16;
  for (int y = 0; y < from.height; ++y) {
    const std::uint16_t* values = from.row(y);
    for (int x = 0; x < from.width; ++x) {
      *to++ = static_cast<std::uint8_t>(values[x] & 0xFF);
      *to++ = static_cast<std::uint8_t>(values[x] >> 8);
    }
  }
}

// The rectified camera, as decimal text under the names of its fields.
void put_camera(const StereoModel& m, image_t& out) {
  const std::array<std::pair<const char*, double>, 6> fields{{{"fx_px", m.fx_px},
                                                              {"fy_px", m.fy_px},
                                                              {"cx_px", m.cx_px},
                                                              {"cy_px", m.cy_px},
                                                              {"baseline_m", m.baseline_m},
                                                              {"doffs_px", m.doffs_px}}};
  out.nmetadata = static_cast<std::int32_t>(fields.size());
  out.metadata.resize(fields.size());
  for (std::size_t i = 0; i < fields.size(); ++i) {
    std::array<char, 32> text{};
    const auto end = fmt::format_to_n(text.data(), text.size(), "{:.17g}", fields[i].second).out;
    image_metadata_t& entry = out.metadata[i];
    entry.key = fields[i].first;
    entry.value.assign(text.data(), end);
    entry.n = static_cast<std::int32_t>(entry.value.size());
  }
}

}  // namespace

void build_images(const TappedImages& images, const StereoModel& model, images_t& out) {
  const std::int64_t utime = floor_us(images.stamp_ns);
  const std::vector<std::uint8_t>& mask = images.zipped_mask;
  out.utime = utime;
  out.image_types = {images_t::LEFT, images_t::DISPARITY};
  if (!images.right.empty()) out.image_types.push_back(images_t::RIGHT);
  if (!mask.empty()) out.image_types.push_back(images_t::MASK_ZIPPED);
  out.n_images = static_cast<std::int32_t>(out.image_types.size());
  out.images.resize(out.image_types.size());
  put_grey(utime, images.left.cview(), out.images[0]);
  put_disparity(images, utime, out.images[1]);
  if (!images.right.empty()) put_grey(utime, images.right.cview(), out.images[2]);
  if (!mask.empty()) {
    std::copy(mask.begin(), mask.end(), begin_image(utime, images.left.cview(), 1, mask.size(), out.images.back()));
  }
  for (image_t& image : out.images) put_camera(model, image);
}

}  // namespace cliquevo::daemon
