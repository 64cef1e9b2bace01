// SPDX-License-Identifier: BSD-3-Clause
// Our own rectification on a real rig, whose calibration OpenCV finds.
#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "stereo/rectify.h"
#include "tests/support/test_data.h"
#include "tests/unit/stereo/as_opencv.h"

namespace cliquevo::stereo {
namespace {

using test::as_mat;
using test::as_view;
using test::data_dir;

// Pairs of a chessboard, and where its corners are.
struct BoardPairs {
  cv::Size board{9, 6};
  std::vector<std::vector<cv::Point2f>> corners[2];
  std::vector<cv::Mat> images[2];
};

bool find_corners(const cv::Mat& image, const cv::Size& board, int flags, std::vector<cv::Point2f>& corners) {
  if (image.empty() || !cv::findChessboardCorners(image, board, corners, flags)) return false;
  cv::cornerSubPix(image, corners, {5, 5}, {-1, -1}, {3, 30, 0.01});
  return true;
}

BoardPairs read_board_pairs() {
  BoardPairs out;
  for (int i = 1; i <= 40 && out.images[0].size() < 12; ++i) {
    cv::Mat pair[2];
    std::vector<cv::Point2f> found[2];
    bool ok = true;
    for (int side = 0; side < 2 && ok; ++side) {
      pair[side] = cv::imread(data_dir() + "/chessboard/" + (side == 0 ? "left" : "right") + std::to_string(i) + ".jpg",
                              cv::IMREAD_GRAYSCALE);
      ok = find_corners(pair[side], out.board, cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_FAST_CHECK, found[side]);
    }
    for (int side = 0; side < 2 && ok; ++side) {
      out.corners[side].push_back(found[side]);
      out.images[side].push_back(pair[side]);
    }
  }
  return out;
}

// By OpenCV; rms: of its reprojection, px.
StereoCalibration calibrate(const BoardPairs& pairs, const std::vector<cv::Point3f>& grid, double& rms) {
  const auto& [board, corners, images] = pairs;
  const std::vector<std::vector<cv::Point3f>> objects(images[0].size(), grid);
  cv::Mat K[2], D[2], R, T, E, F;
  std::vector<cv::Mat> r, t;
  for (int side = 0; side < 2; ++side)
    cv::calibrateCamera(objects, corners[side], images[side][0].size(), K[side], D[side], r, t);
  rms = cv::stereoCalibrate(objects, corners[0], corners[1], K[0], D[0], K[1], D[1], images[0][0].size(), R, T, E, F,
                            cv::CALIB_USE_INTRINSIC_GUESS);
  StereoCalibration c;
  for (int side = 0; side < 2; ++side) {
    CameraCalibration& cam = side == 0 ? c.left : c.right;
    cam = {images[side][0].cols,     images[side][0].rows,     K[side].at<double>(0, 0), K[side].at<double>(1, 1),
           K[side].at<double>(0, 2), K[side].at<double>(1, 2), Distortion::plumb_bob,    {}};
    for (int k = 0; k < 5; ++k) cam.coefficients[k] = D[side].at<double>(k);
  }
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) c.T_right_left.R(i, j) = R.at<double>(i, j);
    c.T_right_left.t(i) = T.at<double>(i);
  }
  return c;
}

// The pairs of a chessboard: calibrate with OpenCV, rectify with ours, find the corners again.
TEST(Rectifier, OwnRectificationOfARealPairLeavesLittleVerticalError) {
  CLIQUEVO_NEEDS_DATA("chessboard");
  const BoardPairs pairs = read_board_pairs();
  const auto& images = pairs.images;
  ASSERT_GE(images[0].size(), 8U);
  std::vector<cv::Point3f> grid;
  for (int y = 0; y < pairs.board.height; ++y) {
    for (int x = 0; x < pairs.board.width; ++x) grid.push_back(cv::Point3d(0.02423 * x, 0.02423 * y, 0.0));
  }
  double rms = 0.0;
  const StereoCalibration c = calibrate(pairs, grid, rms);
  ASSERT_LT(rms, 0.6);
  auto rectifier = Rectifier::make(c);
  ASSERT_TRUE(rectifier.ok()) << rectifier.error().line();
  const StereoModel& m = rectifier->model();
  double sum = 0.0;
  int count = 0;
  std::vector<double> squares;
  for (std::size_t i = 0; i < images[0].size(); ++i) {
    std::vector<cv::Point2f> found[2];
    bool ok = true;
    for (int side = 0; side < 2 && ok; ++side) {
      Image<std::uint8_t> out(m.width, m.height);
      ASSERT_TRUE(
          rectifier->rectify(side == 0 ? CameraSide::left : CameraSide::right, as_view(images[side][i]), out.view())
              .ok());
      ok = find_corners(as_mat(out), pairs.board, cv::CALIB_CB_ADAPTIVE_THRESH, found[side]);
    }
    if (!ok) continue;
    for (std::size_t k = 0; k < grid.size(); ++k) {
      sum += std::pow(found[0][k].y - found[1][k].y, 2);
      ++count;
      if (k % 9 == 0) continue;
      const auto at = [&](std::size_t j) {
        return m.triangulate(found[0][j].x, found[0][j].y, found[0][j].x - found[1][j].x);
      };
      squares.push_back((at(k) - at(k - 1)).norm());
    }
  }
  ASSERT_GT(count, 300);
  EXPECT_LT(std::sqrt(sum / count), 0.35);
  std::nth_element(squares.begin(), squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2), squares.end());
  EXPECT_NEAR(squares[squares.size() / 2], 0.02423, 0.0005);
}

}  // namespace
}  // namespace cliquevo::stereo
