// SPDX-License-Identifier: BSD-3-Clause
// Step A2: corners with depth, spread over the image.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "core/base/camera_model.h"
#include "core/base/image.h"
#include "core/vo/vo_params.h"

namespace cliquevo::vo {

struct Feature {
  int x = 0;  // px, left image
  int y = 0;
  int score = 0;                                    // FAST: the largest threshold at which it still is a corner
  double disparity_px = 0.0;                        // + doffs > 0
  double raw_disparity_px = 0.0;                    // as measured, before the calibration's error was taken out
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  // w, in the left camera's frame, m
  // Change of disparity per px in x and y: the slant of the surface around it.
  double disparity_dx = 0.0;
  double disparity_dy = 0.0;
};

// No feature nearer than this to the border: every window and patch fits.
inline constexpr int kFeatureMargin = 8;

class FeatureDetector {
 public:
  FeatureDetector(const StereoModel& model, const VoParams& params);

  // Fills `features` with at most max_features corners of `image` whose disparity is known. mask: 0 = none here; may be
  // empty. The threshold adapts within the call only: the same picture gives the same features, whatever came before.
  void detect(ImageView<const std::uint8_t> image, ImageView<const std::int16_t> disparity,
              ImageView<const std::uint8_t> mask, double disparity_offset_px, std::vector<Feature>& features);

 private:
  struct Corner {
    std::int16_t x, y, score;
  };
  struct Cell {
    std::vector<std::uint64_t> corners;  // score, then nearness to the first; the best first, as far as in order
    std::size_t in_order = 0;
  };
  void find_corners(ImageView<const std::uint8_t> image, int threshold);
  int next_threshold(int threshold) const;
  void count_usable(ImageView<const std::int16_t> disparity, ImageView<const std::uint8_t> mask,
                    double disparity_offset_px);
  void spread(ImageView<const std::int16_t> disparity, int threshold, std::vector<Feature>& features);

  StereoModel model_;
  VoParams params_;
  std::vector<Corner> corners_;        // in reading order
  Image<std::uint8_t> scores_;         // of three rows in turn
  std::vector<std::int16_t> columns_;  // of a row's maxima
  std::array<int, 256> usable_{};      // corners of each score or a higher one
  int likely_threshold_;               // the last picture's; only the time it takes depends on it
  std::vector<Cell> cells_;
  std::vector<std::uint16_t> cell_across_;  // of each column
};

}  // namespace cliquevo::vo
