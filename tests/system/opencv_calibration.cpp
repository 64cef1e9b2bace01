// SPDX-License-Identifier: BSD-3-Clause
#include "tests/system/opencv_calibration.h"

#include <algorithm>

#include <opencv2/calib3d.hpp>

namespace cliquevo::test {

using calibration::SeenCorner;
using calibration::Side;

namespace {

// Those that the other camera sees too, in the order of their numbers.
std::vector<SeenCorner> shared(std::vector<SeenCorner> corners, const std::vector<SeenCorner>& other) {
  std::erase_if(corners, [&](const SeenCorner& c) {
    return std::none_of(other.begin(), other.end(), [&](const SeenCorner& o) { return o.id == c.id; });
  });
  std::sort(corners.begin(), corners.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  return corners;
}

}  // namespace

OpenCvRig by_opencv(const calibration::Board& board, const std::vector<calibration::View>& views, cv::Size size) {
  std::vector<std::vector<cv::Point3f>> places;
  std::array<std::vector<std::vector<cv::Point2f>>, 2> seen;
  for (const calibration::View& view : views) {
    std::vector<cv::Point3f>& on_board = places.emplace_back();
    for (const SeenCorner& corner : shared(view.left, view.right)) {
      const Eigen::Vector3d p = board.corner(corner.id);
      on_board.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()), 0.0F);
    }
    for (const Side side : {Side::left, Side::right}) {
      auto& corners = seen[static_cast<std::size_t>(side)].emplace_back();
      for (const SeenCorner& corner : shared(view.of(side), view.of(side == Side::left ? Side::right : Side::left))) {
        corners.emplace_back(static_cast<float>(corner.px.x()), static_cast<float>(corner.px.y()));
      }
    }
  }
  std::array<cv::Mat, 2> matrices, lenses;
  std::vector<cv::Mat> turns, shifts;
  for (const int camera : {0, 1}) {
    const auto i = static_cast<std::size_t>(camera);
    cv::calibrateCamera(places, seen[i], size, matrices[i], lenses[i], turns, shifts, cv::CALIB_FIX_K3);
  }
  cv::Mat R, t, essential, fundamental;
  OpenCvRig out;
  out.rms_px = cv::stereoCalibrate(places, seen[0], seen[1], matrices[0], lenses[0], matrices[1], lenses[1], size, R, t,
                                   essential, fundamental, cv::CALIB_USE_INTRINSIC_GUESS | cv::CALIB_FIX_K3,
                                   {cv::TermCriteria::EPS + cv::TermCriteria::MAX_ITER, 100, 1e-6});
  for (std::size_t i = 0; i < 2; ++i) {
    const auto& m = matrices[i];
    out.lenses[i] = {m.at<double>(0, 0), m.at<double>(1, 1), m.at<double>(0, 2), m.at<double>(1, 2)};
    for (int k = 0; k < 4; ++k) out.lenses[i][static_cast<std::size_t>(4 + k)] = lenses[i].at<double>(k);
  }
  out.baseline_m = cv::norm(t);
  return out;
}

}  // namespace cliquevo::test
