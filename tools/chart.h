// SPDX-License-Identifier: BSD-3-Clause
// Line charts drawn with OpenCV: axes with ticks and labels, a grid, a legend, lines and marks.
#pragma once

#include <string>
#include <vector>

#include <opencv2/core.hpp>

namespace cliquevo::tools {

enum class Mark { none, disc, ring, square, cross };

struct Series {
  std::string label;  // empty: not in the legend
  std::vector<cv::Point2d> points;
  cv::Scalar color;       // blue green red
  double width_px = 2.0;  // of the line, 0 = none
  Mark mark = Mark::none;
  double mark_px = 6.0;  // half its size
  bool dashed = false;
};

struct Chart {
  std::string title;
  std::string x_label;
  std::string y_label;
  bool equal_aspect = false;   // one metre is as long on both axes
  bool from_zero = false;      // both axes
  std::vector<Series> series;  // drawn in order
};

// Tick positions at steps of 1, 2 or 5 times a power of ten, about `wanted` of them, inside [low, high].
std::vector<double> tick_positions(double low, double high, int wanted);

// Draws into a part of a figure. Pixels are those of the finished figure; see render_figure.
class Figure {
 public:
  Figure(int width_px, int height_px);
  void draw(const Chart& chart, cv::Rect2d area_px);
  void text(const std::string& text, cv::Point2d at_px, double height_px, const cv::Scalar& color);
  // The finished 8-bit BGR picture.
  cv::Mat render() const;

 private:
  cv::Mat canvas_;  // several times the finished size: scaled down, edges come out smooth
};

}  // namespace cliquevo::tools
