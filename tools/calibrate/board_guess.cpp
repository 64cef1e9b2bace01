// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/board_guess.h"

#include <algorithm>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <opencv2/aruco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "tools/calibrate/markers.h"

namespace cliquevo::tools {

namespace {

using calibration::Board;
using calibration::BoardKind;

constexpr int kRange = 2;         // columns and rows that are tried around those of the board,
constexpr int kWidth_px = 400;    // in an image of this width: it takes long
constexpr int kLeastMarkers = 3;  // fewer may be chance

bool has_markers(BoardKind kind) { return kind == BoardKind::charuco || kind == BoardKind::aprilgrid; }

// Columns and rows about these, the largest first: a smaller one is found within.
std::vector<std::pair<int, int>> sizes_about(int columns, int rows) {
  std::vector<std::pair<int, int>> out;
  for (int c = std::max(3, columns - kRange); c <= columns + kRange; ++c) {
    for (int r = std::max(3, rows - kRange); r <= rows + kRange; ++r) out.emplace_back(c, r);
  }
  std::sort(out.begin(), out.end(),
            [](const auto& a, const auto& b) { return a.first * a.second > b.first * b.second; });
  return out;
}

bool is_chessboard(const cv::Mat& image, int columns, int rows) {
  constexpr int kFlags = cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK;
  std::vector<cv::Point2f> corners;
  return cv::findChessboardCorners(image, {columns, rows}, corners, kFlags);
}

std::string other_size(const Board& board, const cv::Mat& image) {
  const bool circles = board.kind == BoardKind::circles;
  const char* what = circles ? "dots" : "corners";
  for (const auto& [columns, rows] : sizes_about(board.columns, board.rows)) {
    if (columns == board.columns && rows == board.rows) continue;
    std::vector<cv::Point2f> dots;
    const bool seen = circles ? cv::findCirclesGrid(image, {columns, rows}, dots) : is_chessboard(image, columns, rows);
    if (seen) {
      return fmt::format("{}x{} {} are seen, {}x{} were named", columns, rows, what, board.columns, board.rows);
    }
  }
  return "";
}

std::size_t markers_in(const cv::Mat& image, cv::aruco::PREDEFINED_DICTIONARY_NAME dictionary, int border) {
  auto parameters = cv::aruco::DetectorParameters::create();
  parameters->markerBorderBits = border;
  std::vector<std::vector<cv::Point2f>> corners;
  std::vector<int> ids;
  cv::aruco::detectMarkers(image, cv::aruco::getPredefinedDictionary(dictionary), corners, ids, parameters);
  return ids.size();
}

std::string other_kind(const Board& board, const cv::Mat& full, const cv::Mat& small) {
  const std::size_t aruco = markers_in(full, cv::aruco::DICT_5X5_1000, 1);
  if (aruco >= kLeastMarkers && board.kind != BoardKind::charuco) {
    return fmt::format("{} markers of a charuco board are seen", aruco);
  }
  const std::size_t tags = std::max(markers_in(full, cv::aruco::DICT_APRILTAG_36h11, kKalibrsBorder),
                                    markers_in(full, cv::aruco::DICT_APRILTAG_36h11, 1));
  if (tags >= kLeastMarkers && board.kind != BoardKind::aprilgrid) {
    return fmt::format("{} tags of an aprilgrid are seen", tags);
  }
  if (board.kind == BoardKind::chessboard) return "";
  for (const auto& [columns, rows] : sizes_about(board.columns - 1, board.rows - 1)) {
    if (is_chessboard(small, columns, rows))
      return fmt::format("a chessboard with {}x{} corners is seen", columns, rows);
  }
  return "";
}

}  // namespace

std::string guess_board(const Board& board, const BoardDetector& detector, ImageView<const std::uint8_t> image) {
  // OpenCV takes no pointer to const; the image is only read.
  const cv::Mat full(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.data),
                     static_cast<std::size_t>(image.stride));
  if (has_markers(board.kind)) {
    cv::Mat mirrored;
    cv::flip(full, mirrored, 1);
    const ImageView<const std::uint8_t> view(mirrored.data, mirrored.cols, mirrored.rows,
                                             static_cast<std::ptrdiff_t>(mirrored.step));
    if (!detector.find(view).empty()) return "the board is seen in the mirrored image: a mirror is in the way";
  }
  cv::Mat small = full;
  if (full.cols > kWidth_px) {
    const double scale = static_cast<double>(kWidth_px) / full.cols;
    cv::resize(full, small, {}, scale, scale, cv::INTER_AREA);
  }
  // The squares of a charuco board are a chessboard, too: markers say more.
  const std::string kind = other_kind(board, full, small);
  return kind.empty() && !has_markers(board.kind) ? other_size(board, small) : kind;
}

}  // namespace cliquevo::tools
