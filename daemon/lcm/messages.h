// SPDX-License-Identifier: BSD-3-Clause
// From estimates to messages: units, frames and the promise that every number sent is finite. Knows no transport.
#pragma once

#include <cstdint>
#include <optional>

#include <cliquevo/features_t.hpp>
#include <cliquevo/images_t.hpp>
#include <cliquevo/movers_t.hpp>
#include <cliquevo/odometry_t.hpp>
#include <cliquevo/pose_t.hpp>
#include <cliquevo/status_t.hpp>
#include <cliquevo/update_t.hpp>

#include "core/base/rigid_transform.h"
#include "core/base/time.h"
#include "core/vo/visual_odometry.h"
#include "daemon/lcm/feature_tap.h"
#include "daemon/lcm/image_tap.h"
#include "daemon/lcm/odometry_builder.h"
#include "daemon/pipeline/published_frame.h"

namespace cliquevo::daemon {

// Variance (m^2, rad^2) sent where a covariance is not finite: "unknown".
inline constexpr double kUnknownVariance = 1e6;

// ns -> µs, always rounded down (also below zero), so that one exposure has one µs stamp in every message.
constexpr std::int64_t floor_us(std::int64_t ns) { return ns / 1000 - (ns % 1000 < 0 ? 1 : 0); }

// Everything that goes out for one frame.
struct FrameMessages {
  update_t delta{};
  update_t delta_body{};
  pose_t pose{};
  status_t status{};
  odometry_t odometry{};
};

// The images as VO_IMAGES sends them, with the camera they are of. Allocates the first time only.
void build_images(const TappedImages& images, const StereoModel& model, images_t& out);

// What moves by itself as VO_MOVERS sends it; a thing with a number that is not finite is left out.
void build_movers(const vo::Movers& movers, movers_t& out);

// What became of the features as VO_FEATURES sends it; numbers that are not finite become 0. Allocates while it grows.
void build_features(const TappedFeatures& tapped, const StereoModel& model, const RigidTransform& T_body_camera,
                    features_t& out);

class MessageBuilder {
 public:
  explicit MessageBuilder(const RigidTransform& T_body_camera);

  // Fills `out` from `frame`; `publish_ns` (UTC) is the time that VO_STATUS gives for sending. No allocation.
  // A failed frame's delta is the identity; ambiguous becomes degenerate in the delta. A number that is not finite is
  // replaced (identity, unknown variance, last good pose, 0), the delta's status is then degenerate at best, and
  // `repaired` is set.
  void build(const PublishedFrame& frame, TimestampNs publish_ns, FrameMessages& out);

 private:
  void build_delta(const vo::Estimate& estimate, bool finite, update_t& out) const;
  // The camera's delta as the body's, its covariance turned with it.
  void build_delta_body(const vo::Estimate& estimate, const update_t& delta, update_t& out) const;
  void build_pose(const PublishedFrame& frame, bool finite, pose_t& out);
  static void build_checks(const vo::Estimate& estimate, status_t& out);
  void build_status(const PublishedFrame& frame, TimestampNs publish_ns, status_t& out) const;

  struct SentPose {
    RigidTransform T_world_body;
    TimestampNs stamp_ns = 0;
    std::int32_t resets = 0;
  };
  RigidTransform T_body_camera_;
  RigidTransform T_camera_body_;
  Matrix6d adjoint_body_camera_;
  std::optional<SentPose> last_;
  OdometryBuilder odometry_;
};

}  // namespace cliquevo::daemon
