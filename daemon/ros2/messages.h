// SPDX-License-Identifier: BSD-3-Clause
// ROS 2 messages in CDR, of what cliquevo has. Frames: odom, base_link (the body), camera_left_optical_frame.
#pragma once

#include <array>
#include <span>
#include <string_view>
#include <vector>

#include <Eigen/Core>
#include <cliquevo/odometry_t.hpp>
#include <cliquevo/points_t.hpp>
#include <cliquevo/pose_t.hpp>

#include "core/base/camera_model.h"
#include "core/base/image.h"
#include "core/base/rigid_transform.h"
#include "drivers/bags/cdr_writer.h"

namespace cliquevo::ros2 {

inline constexpr std::string_view kOdomFrame = "odom";
inline constexpr std::string_view kBodyFrame = "base_link";
inline constexpr std::string_view kLeftFrame = "camera_left_optical_frame";
inline constexpr std::string_view kRightFrame = "camera_right_optical_frame";

void put_image(TimestampNs stamp_ns, std::string_view frame, ImageView<const std::uint8_t> image,
               drivers::CdrWriter& out);
// The same as a CompressedImage. file: a whole PNG.
void put_png(TimestampNs stamp_ns, std::string_view frame, std::span<const std::uint8_t> file, drivers::CdrWriter& out);
// 32FC1: px, NaN where unknown or not above 0. disparity: px * 16.
void put_disparity(TimestampNs stamp_ns, std::string_view frame, ImageView<const std::int16_t> disparity,
                   drivers::CdrWriter& out);
// R and P are the prescribed rectification's, zeros where there is none; of rectified images K is P's.
void put_camera_info(TimestampNs stamp_ns, const StereoCalibration& calibration, bool left, drivers::CdrWriter& out);
void put_odometry(const odometry_t& m, drivers::CdrWriter& out);
void put_pose(TimestampNs stamp_ns, const Eigen::Vector3d& position, const Eigen::Vector4d& wxyz,
              drivers::CdrWriter& out);
void put_transform(TimestampNs stamp_ns, std::string_view frame, std::string_view child, const RigidTransform& T,
                   drivers::CdrWriter& out);
// A PointCloud2 with x, y, z.
void put_points(TimestampNs stamp_ns, std::string_view frame, std::span<const Eigen::Vector3f> points,
                drivers::CdrWriter& out);
// A PointCloud2 in the body's frame with the fields of kPointFields, a float each. Of lists that differ in length what
// the shortest has.
void put_points(const points_t& m, drivers::CdrWriter& out);
inline constexpr std::array<const char*, 5> kPointFields{"x", "y", "z", "sigma", "intensity"};
std::size_t count_of(const points_t& m);
// What the odometry says of itself.
void put_diagnostics(const odometry_t& m, drivers::CdrWriter& out);

// The name of a verdict, as a sentence for people.
std::string_view verdict_text(int status);
RigidTransform pose_of(const odometry_t& m);

}  // namespace cliquevo::ros2
