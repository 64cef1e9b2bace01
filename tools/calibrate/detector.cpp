// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/detector.h"

#include <algorithm>
#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <cmath>
#include <map>

#include <opencv2/aruco/charuco.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "tools/calibrate/board_guess.h"
#include "tools/calibrate/markers.h"
#include "tools/calibrate/refine_corners.h"

namespace cliquevo::tools {

namespace {

using calibration::Board;
using calibration::BoardKind;
using calibration::SeenCorner;

constexpr int kLeastCorners = 6;      // of a board that may be seen in part
constexpr double kMostOfTag = 0.125;  // of a tag's side: farther in, its bits begin
constexpr int kSubPixIterations = 40;
constexpr double kSubPixStep_px = 1e-3;
constexpr double kWindowOfSquare = 0.35;  // half side of the window in which a corner is refined, of a square's side
constexpr int kMostWindow = 11;
constexpr int kLeastWindow = 2;
constexpr double kFreeOfMargin = 0.8;  // of the white between a charuco board's corner and the nearest marker

cv::Mat header_of(ImageView<const std::uint8_t> image) {
  // OpenCV takes no pointer to const; the image is only read.
  return {image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.data),
          static_cast<std::size_t>(image.stride)};
}

// Smallest distance between corners, px: how far a window may reach.
double least_distance(const std::vector<cv::Point2f>& corners) {
  double least = 1e9;
  for (std::size_t i = 1; i < corners.size(); ++i) least = std::min(least, cv::norm(corners[i] - corners[i - 1]));
  return least;
}

void refine_by_gradients(const cv::Mat& image, std::vector<cv::Point2f>& corners, double spacing_px) {
  if (corners.empty()) return;
  const int half = std::clamp(static_cast<int>(kWindowOfSquare * spacing_px), kLeastWindow, kMostWindow);
  cv::cornerSubPix(image, corners, {half, half}, {-1, -1},
                   {cv::TermCriteria::EPS + cv::TermCriteria::MAX_ITER, kSubPixIterations, kSubPixStep_px});
}

std::vector<SeenCorner> numbered(const std::vector<cv::Point2f>& corners) {
  std::vector<SeenCorner> out;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    out.push_back({static_cast<int>(i), {static_cast<double>(corners[i].x), static_cast<double>(corners[i].y)}});
  }
  return out;
}

// Mean side of the markers.
double side_px(const std::vector<std::vector<cv::Point2f>>& markers) {
  double sum = 0.0;
  for (const auto& corners : markers) sum += least_distance(corners);
  return markers.empty() ? 0.0 : sum / static_cast<double>(markers.size());
}

bool find_chessboard(const cv::Mat& image, int columns, int rows, int flags, std::vector<cv::Point2f>& corners) {
  return cv::findChessboardCorners(image, {columns, rows}, corners, flags);
}

}  // namespace

struct BoardDetector::Impl {
  explicit Impl(const Board& b) : board(b) {
    if (board.kind == BoardKind::charuco) {
      dictionary = cv::aruco::getPredefinedDictionary(dictionary_for(board));
      charuco = cv::aruco::CharucoBoard::create(board.columns, board.rows, static_cast<float>(board.size_m),
                                                static_cast<float>(board.size_m * board.ratio), dictionary);
    }
    if (board.kind == BoardKind::aprilgrid) {
      for (const int border : {kKalibrsBorder, 1}) {
        apriltag_family_t* family = tag_family(border);
        apriltag_detector_t* detector = apriltag_detector_create();
        apriltag_detector_add_family(detector, family);
        detector->quad_decimate = 1.0F;
        detector->nthreads = 1;
        families.push_back(family);
        tags.push_back(detector);
      }
    }
  }
  ~Impl() {
    for (apriltag_detector_t* detector : tags) apriltag_detector_destroy(detector);
    for (apriltag_family_t* family : families) tag36h11_destroy(family);
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;

  std::vector<SeenCorner> chessboard(const cv::Mat& image) const {
    std::vector<cv::Point2f> corners;
    constexpr int kFlags = cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_FAST_CHECK;
    if (!find_chessboard(image, board.columns, board.rows, kFlags, corners)) return {};
    refine_by_gradients(image, corners, least_distance(corners));
    return numbered(corners);
  }

  std::vector<SeenCorner> circles(const cv::Mat& image) const {
    std::vector<cv::Point2f> centres;
    if (!cv::findCirclesGrid(image, {board.columns, board.rows}, centres)) return {};
    return numbered(centres);
  }

  std::vector<SeenCorner> markers(const cv::Mat& image) const {
    std::vector<std::vector<cv::Point2f>> found;
    std::vector<int> ids;
    auto parameters = cv::aruco::DetectorParameters::create();
    cv::aruco::detectMarkers(image, dictionary, found, ids, parameters);
    if (ids.empty()) return {};
    std::vector<cv::Point2f> corners;
    std::vector<int> corner_ids;
    cv::aruco::interpolateCornersCharuco(found, ids, image, charuco, corners, corner_ids);
    // Once more, as far as the markers let the window reach.
    const double square_px = side_px(found) / board.ratio;
    refine_by_gradients(image, corners, kFreeOfMargin * 0.5 * (1.0 - board.ratio) * square_px / kWindowOfSquare);
    std::vector<SeenCorner> out;
    for (std::size_t i = 0; i < corners.size(); ++i) {
      out.push_back({corner_ids[i], {static_cast<double>(corners[i].x), static_cast<double>(corners[i].y)}});
    }
    return static_cast<int>(out.size()) >= kLeastCorners ? out : std::vector<SeenCorner>{};
  }

  // Kalibr's tags have a border of two cells, those of the AprilTag library of one. And its small squares touch the
  // tags' corners, so that some are found only when dark things are made a little smaller.
  std::vector<SeenCorner> april_tags(const cv::Mat& image) const {
    std::map<int, std::vector<cv::Point2f>> found;
    cv::Mat thinner;
    cv::dilate(image, thinner, cv::Mat());
    for (const cv::Mat* view : {&image, static_cast<const cv::Mat*>(&thinner)}) {
      for (apriltag_detector_t* detector : tags) {
        detect_tags(*view, detector, found);
      }
    }
    std::vector<SeenCorner> out;
    for (auto& [id, corners] : found) {
      refine_by_gradients(image, corners, least_distance(corners) * std::min(board.ratio, kMostOfTag));
      for (int k = 0; k < 4; ++k) {
        const cv::Point2f& p = corners[static_cast<std::size_t>(k)];
        out.push_back({4 * id + k, {static_cast<double>(p.x), static_cast<double>(p.y)}});
      }
    }
    return static_cast<int>(out.size()) >= kLeastCorners ? out : std::vector<SeenCorner>{};
  }

  void detect_tags(const cv::Mat& image, apriltag_detector_t* detector,
                   std::map<int, std::vector<cv::Point2f>>& found) const {
    image_u8_t view{image.cols, image.rows, static_cast<std::int32_t>(image.step), image.data};
    zarray_t* detections = apriltag_detector_detect(detector, &view);
    for (int i = 0; i < zarray_size(detections); ++i) {
      apriltag_detection_t* d = nullptr;
      zarray_get(detections, i, &d);
      if (d->id < 0 || d->id >= board.columns * board.rows || d->hamming > 1 || found.contains(d->id)) continue;
      std::vector<cv::Point2f>& corners = found[d->id];
      // The library takes the first pixel's centre as 0.5.
      for (const auto& p : d->p) {
        corners.emplace_back(static_cast<float>(p[0] - 0.5), static_cast<float>(p[1] - 0.5));
      }
    }
    apriltag_detections_destroy(detections);
  }

  std::vector<SeenCorner> find(const cv::Mat& image) const {
    switch (board.kind) {
      case BoardKind::chessboard:
        return chessboard(image);
      case BoardKind::charuco:
        return markers(image);
      case BoardKind::aprilgrid:
        return april_tags(image);
      case BoardKind::circles:
        break;
    }
    return circles(image);
  }

  Board board;
  cv::Ptr<cv::aruco::Dictionary> dictionary;
  cv::Ptr<cv::aruco::CharucoBoard> charuco;
  std::vector<apriltag_family_t*> families;
  std::vector<apriltag_detector_t*> tags;  // one a family
};

BoardDetector::BoardDetector(const Board& board) : impl_(std::make_unique<Impl>(board)) {}
BoardDetector::~BoardDetector() = default;

std::vector<SeenCorner> BoardDetector::find_roughly(ImageView<const std::uint8_t> image) const {
  return impl_->find(header_of(image));
}

void BoardDetector::refine(ImageView<const std::uint8_t> image, std::vector<SeenCorner>& corners) const {
  refine_corners(image, impl_->board, corners);
}

std::vector<SeenCorner> BoardDetector::find(ImageView<const std::uint8_t> image) const {
  std::vector<SeenCorner> corners = find_roughly(image);
  refine(image, corners);
  return corners;
}

std::string BoardDetector::nearest_guess(ImageView<const std::uint8_t> image) const {
  return guess_board(impl_->board, *this, image);
}

}  // namespace cliquevo::tools
