// SPDX-License-Identifier: BSD-3-Clause
// The pipeline that users put together from OpenCV: corners, Lucas-Kanade, PnP with RANSAC, on a given disparity. The
// peer in the odometry bench; not part of the product.
#pragma once

#include <vector>

#include <opencv2/core.hpp>

#include "core/base/camera_model.h"
#include "core/base/image.h"
#include "core/base/rigid_transform.h"

namespace cliquevo::bench {

enum class Corners { good_features, fast };

struct OpenCvParams {
  Corners corners = Corners::good_features;
  int max_features = 500;
  double min_distance_px = 8.0;  // between good features
  int fast_threshold = 20;
  int window_px = 21;  // Lucas-Kanade, OpenCV's default window and pyramid
  int pyramid_levels = 3;
  int ransac_iterations = 100;
  double ransac_error_px = 1.0;
  double confidence = 0.999;
};

class OpenCvOdometry {
 public:
  OpenCvOdometry(const StereoModel& model, const OpenCvParams& params) : model_(model), params_(params) {}

  // One frame; false when no motion was found: the pose then carries on with the last motion.
  bool process(ImageView<const std::uint8_t> left, ImageView<const std::int16_t> disparity);
  const RigidTransform& T_world_camera() const { return T_world_camera_; }
  int inliers() const { return inliers_; }

 private:
  std::vector<cv::Point2f> find_corners(const cv::Mat& left) const;
  bool estimate(const cv::Mat& left);
  void remember(const cv::Mat& left, ImageView<const std::int16_t> disparity);

  StereoModel model_;
  OpenCvParams params_;
  cv::Mat last_left_;
  std::vector<cv::Point2f> last_corners_;  // those with depth
  std::vector<cv::Point3f> last_points_;
  RigidTransform T_prev_cur_;
  RigidTransform T_world_camera_;
  int inliers_ = 0;
};

}  // namespace cliquevo::bench
