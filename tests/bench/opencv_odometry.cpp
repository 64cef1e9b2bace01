// SPDX-License-Identifier: BSD-3-Clause
#include "tests/bench/opencv_odometry.h"

#include <algorithm>
#include <cmath>

#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace cliquevo::bench {

std::vector<cv::Point2f> OpenCvOdometry::find_corners(const cv::Mat& left) const {
  std::vector<cv::Point2f> corners;
  if (params_.corners == Corners::good_features) {
    cv::goodFeaturesToTrack(left, corners, params_.max_features, 0.01, params_.min_distance_px);
    return corners;
  }
  std::vector<cv::KeyPoint> found;
  cv::FAST(left, found, params_.fast_threshold);
  cv::KeyPointsFilter::retainBest(found, params_.max_features);
  cv::KeyPoint::convert(found, corners);
  return corners;
}

bool OpenCvOdometry::estimate(const cv::Mat& left) {
  inliers_ = 0;
  if (last_corners_.size() < 6) return false;
  std::vector<cv::Point2f> tracked;
  std::vector<unsigned char> found;
  std::vector<float> error;
  cv::calcOpticalFlowPyrLK(last_left_, left, last_corners_, tracked, found, error,
                           cv::Size(params_.window_px, params_.window_px), params_.pyramid_levels);
  std::vector<cv::Point3f> points;
  std::vector<cv::Point2f> pixels;
  for (std::size_t i = 0; i < tracked.size(); ++i) {
    if (found[i] == 0) continue;
    points.push_back(last_points_[i]);
    pixels.push_back(tracked[i]);
  }
  if (points.size() < 6) return false;
  const cv::Matx33d K(model_.fx_px, 0, model_.cx_px, 0, model_.fy_px, model_.cy_px, 0, 0, 1);
  cv::Vec3d rotation(0, 0, 0);
  cv::Vec3d translation(0, 0, 0);
  std::vector<int> inliers;
  cv::setRNGSeed(1);
  if (!cv::solvePnPRansac(points, pixels, K, cv::noArray(), rotation, translation, false, params_.ransac_iterations,
                          static_cast<float>(params_.ransac_error_px), params_.confidence, inliers)) {
    return false;
  }
  if (inliers.size() < 6) return false;
  std::vector<cv::Point3f> inlier_points;
  std::vector<cv::Point2f> inlier_pixels;
  for (const int i : inliers) {
    inlier_points.push_back(points[static_cast<std::size_t>(i)]);
    inlier_pixels.push_back(pixels[static_cast<std::size_t>(i)]);
  }
  cv::solvePnPRefineLM(inlier_points, inlier_pixels, K, cv::noArray(), rotation, translation);
  RigidTransform T_cur_prev;
  T_cur_prev.R = so3_exp(Eigen::Vector3d(rotation[0], rotation[1], rotation[2]));
  T_cur_prev.t = Eigen::Vector3d(translation[0], translation[1], translation[2]);
  if (!T_cur_prev.is_finite()) return false;
  T_prev_cur_ = T_cur_prev.inverse();
  inliers_ = static_cast<int>(inliers.size());
  return true;
}

void OpenCvOdometry::remember(const cv::Mat& left, ImageView<const std::int16_t> disparity) {
  last_left_ = left.clone();
  last_corners_.clear();
  last_points_.clear();
  for (const cv::Point2f& corner : find_corners(left)) {
    const int x = cvRound(corner.x);
    const int y = cvRound(corner.y);
    if (!disparity.contains(x, y) || disparity(x, y) == kUnknownDisparity) continue;
    const double d = static_cast<double>(disparity(x, y)) / kDisparityScale;
    if (d + model_.doffs_px <= 0.5) continue;
    const Eigen::Vector3d p = model_.triangulate(corner.x, corner.y, d);
    last_corners_.push_back(corner);
    last_points_.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
  }
}

bool OpenCvOdometry::process(ImageView<const std::uint8_t> left, ImageView<const std::int16_t> disparity) {
  // OpenCV has no views of constant memory; nothing below writes to it.
  const cv::Mat image(left.height, left.width, CV_8UC1, const_cast<std::uint8_t*>(left.data),
                      static_cast<std::size_t>(left.stride));
  const bool first = last_left_.empty();
  const bool found = first || estimate(image);
  if (!first) T_world_camera_ = (T_world_camera_ * T_prev_cur_).normalized();
  remember(image, disparity);
  return found;
}

}  // namespace cliquevo::bench
