// SPDX-License-Identifier: BSD-3-Clause
#include "tools/message_json.h"

#include <algorithm>
#include <cstdint>
#include <string>

#include <cliquevo/command_t.hpp>
#include <cliquevo/features_t.hpp>
#include <cliquevo/health_t.hpp>
#include <cliquevo/images_t.hpp>
#include <cliquevo/movers_t.hpp>
#include <cliquevo/odometry_t.hpp>
#include <cliquevo/points_t.hpp>
#include <cliquevo/pose_t.hpp>
#include <cliquevo/status_t.hpp>
#include <cliquevo/update_t.hpp>

#include "daemon/lcm/message_sizes.h"

namespace cliquevo::tools {

namespace {

using nlohmann::ordered_json;

ordered_json json_of(const pose_t& m) {
  return {{"utime", m.utime},
          {"pos", m.pos},
          {"vel", m.vel},
          {"orientation", m.orientation},
          {"rotation_rate", m.rotation_rate},
          {"accel", m.accel}};
}

ordered_json rows_of(const double (&matrix)[6][6]) {
  ordered_json out = ordered_json::array();
  for (const auto& row : matrix) out.push_back(row);
  return out;
}

ordered_json json_of(const update_t& m) {
  return {{"timestamp", m.timestamp}, {"prev_timestamp", m.prev_timestamp},  {"translation", m.translation},
          {"rotation", m.rotation},   {"covariance", rows_of(m.covariance)}, {"estimate_status", m.estimate_status}};
}

ordered_json json_of(const odometry_t& m) {
  return {{"utime", m.utime},
          {"publish_utime", m.publish_utime},
          {"prev_utime", m.prev_utime},
          {"position", m.position},
          {"orientation", m.orientation},
          {"pose_covariance", rows_of(m.pose_covariance)},
          {"velocity", m.velocity},
          {"rotation_rate", m.rotation_rate},
          {"twist_covariance", rows_of(m.twist_covariance)},
          {"quality", m.quality},
          {"status", m.status},
          {"pose_is_guess", m.pose_is_guess != 0},
          {"reset_counter", m.reset_counter}};
}

ordered_json json_of(const status_t& m) {
  return {{"utime", m.utime},
          {"publish_utime", m.publish_utime},
          {"frame", m.frame},
          {"status", m.status},
          {"pose_is_guess", m.pose_is_guess != 0},
          {"repaired", m.repaired != 0},
          {"features", m.features},
          {"matches", m.matches},
          {"clique", m.clique},
          {"inliers", m.inliers},
          {"reprojection_error_px", m.reprojection_error_px},
          {"eigenvalue_ratio", m.eigenvalue_ratio},
          {"quality", m.quality},
          {"check_ratio", m.check_ratio},
          {"checks_failed", m.checks_failed},
          {"expected_error_px", m.expected_error_px},
          {"disparity_shift_px", m.disparity_shift_px},
          {"disparity_shift_sigma_px", m.disparity_shift_sigma_px},
          {"rectify_us", m.rectify_us},
          {"stereo_us", m.stereo_us},
          {"odometry_us", m.odometry_us},
          {"features_us", m.features_us},
          {"scores_us", m.scores_us},
          {"matches_us", m.matches_us},
          {"clique_us", m.clique_us},
          {"motion_us", m.motion_us},
          {"grabbed_utime", m.grabbed_utime},
          {"stereo_begin_utime", m.stereo_begin_utime},
          {"stereo_end_utime", m.stereo_end_utime},
          {"odometry_begin_utime", m.odometry_begin_utime},
          {"odometry_end_utime", m.odometry_end_utime},
          {"dropped", m.dropped},
          {"resets", m.resets},
          {"disparity_offset_px", m.disparity_offset_px},
          {"disparity_offset_sigma_px", m.disparity_offset_sigma_px},
          {"vertical_px", m.vertical_px},
          {"vertical_sigma_px", m.vertical_sigma_px},
          {"calibration_off", m.calibration_off != 0},
          {"vehicle_in_view", m.vehicle_in_view != 0}};
}

ordered_json json_of(const health_t& m) {
  return {{"utime", m.utime},
          {"state", m.state},
          {"state_text", m.state_text},
          {"uptime_s", m.uptime_s},
          {"grab_rate_hz", m.grab_rate_hz},
          {"pose_rate_hz", m.pose_rate_hz},
          {"valid_share", m.valid_share},
          {"frames_grabbed", m.frames_grabbed},
          {"poses_sent", m.poses_sent},
          {"frames_dropped", m.frames_dropped},
          {"frames_rejected", m.frames_rejected},
          {"source_errors", m.source_errors},
          {"send_errors", m.send_errors},
          {"resets", m.resets},
          {"latency_p50_us", m.latency_p50_us},
          {"latency_p99_us", m.latency_p99_us},
          {"latency_max_us", m.latency_max_us},
          {"latency_p999_us", m.latency_p999_us},
          {"stage_name", m.stage_name},
          {"stage_p50_us", m.stage_p50_us},
          {"stage_p99_us", m.stage_p99_us},
          {"resident_bytes", m.resident_bytes},
          {"temperature_name", m.temperature_name},
          {"temperature_c", m.temperature_c},
          {"source_text", m.source_text},
          {"recording_text", m.recording_text},
          {"incident_text", m.incident_text},
          {"calibration_text", m.calibration_text},
          {"right_eye_deg", m.right_eye_deg},
          {"right_eye_sigma_deg", m.right_eye_sigma_deg},
          {"view_text", m.view_text}};
}

ordered_json json_of(const mover_t& m) {
  return {{"id", m.id},
          {"frames", m.frames},
          {"of_vehicle", m.of_vehicle != 0},
          {"centre", m.centre},
          {"velocity", m.velocity},
          {"translation", m.translation},
          {"rotation", m.rotation},
          {"covariance", rows_of(m.covariance)},
          {"reprojection_error_px", m.reprojection_error_px},
          {"inliers", m.inliers},
          {"pixel", m.pixel},
          {"point", m.point}};
}

ordered_json json_of(const movers_t& m) {
  ordered_json movers = ordered_json::array();
  for (const mover_t& mover : m.movers) movers.push_back(json_of(mover));
  return {{"utime", m.utime}, {"prev_utime", m.prev_utime}, {"movers", movers}};
}

ordered_json json_of(const features_t& m) {
  return {{"utime", m.utime},
          {"width", m.width},
          {"height", m.height},
          {"fx_px", m.fx_px},
          {"fy_px", m.fy_px},
          {"cx_px", m.cx_px},
          {"cy_px", m.cy_px},
          {"baseline_m", m.baseline_m},
          {"doffs_px", m.doffs_px},
          {"camera_translation", m.camera_translation},
          {"camera_rotation", m.camera_rotation},
          {"check_value", m.check_value},
          {"check_bound", m.check_bound},
          {"x", m.x},
          {"y", m.y},
          {"from_x", m.from_x},
          {"from_y", m.from_y},
          {"disparity", m.disparity},
          {"error", m.error},
          {"role", m.role}};
}

ordered_json json_of(const points_t& m) {
  return {{"utime", m.utime},
          {"camera_position", m.camera_position},
          {"step_px", m.step_px},
          {"x", m.x},
          {"y", m.y},
          {"z", m.z},
          {"sigma", m.sigma},
          {"grey", m.grey}};
}

bool is_plain_text(const auto& bytes) {
  return std::all_of(bytes.begin(), bytes.end(), [](auto c) { return c >= 0x20 && c < 0x7F; });
}

// What is text: of VO_IMAGES the camera.
ordered_json metadata_of(const image_t& image) {
  ordered_json out = ordered_json::object();
  for (const image_metadata_t& entry : image.metadata) {
    if (is_plain_text(entry.key) && is_plain_text(entry.value)) {
      out[entry.key] = std::string(entry.value.begin(), entry.value.end());
    }
  }
  return out;
}

ordered_json json_of(const images_t& m) {
  ordered_json images = ordered_json::array();
  for (const image_t& image : m.images) {
    images.push_back({{"width", image.width},
                      {"height", image.height},
                      {"row_stride", image.row_stride},
                      {"pixelformat", image.pixelformat},
                      {"size", image.size},
                      {"metadata", metadata_of(image)}});
  }
  return {{"utime", m.utime}, {"image_types", m.image_types}, {"images", images}};
}

ordered_json json_of(const command_t& m) {
  return {{"utime", m.utime}, {"command", m.command}, {"argument", m.argument}};
}

template <typename Message>
std::optional<ordered_json> decoded(const void* data, std::size_t size) {
  Message message;
  if (!daemon::decode_checked(data, size, message)) return std::nullopt;
  return json_of(message);
}

struct Type {
  std::int64_t fingerprint;
  std::optional<ordered_json> (*decode)(const void* data, std::size_t size);
};
template <typename Message>
Type type() {
  return {Message::getHash(), decoded<Message>};
}

}  // namespace

std::optional<ordered_json> message_json(const void* data, std::size_t size) {
  static const Type types[] = {type<pose_t>(),   type<update_t>(), type<status_t>(),   type<odometry_t>(),
                               type<health_t>(), type<movers_t>(), type<features_t>(), type<images_t>(),
                               type<points_t>(), type<command_t>()};
  if (size < 8) return std::nullopt;
  std::uint64_t fingerprint = 0;
  for (int i = 0; i < 8; ++i) fingerprint = fingerprint << 8U | static_cast<const std::uint8_t*>(data)[i];
  for (const Type& each : types) {
    if (static_cast<std::uint64_t>(each.fingerprint) == fingerprint) return each.decode(data, size);
  }
  return std::nullopt;
}

}  // namespace cliquevo::tools
