// SPDX-License-Identifier: BSD-3-Clause
// Line charts: axes with ticks and labels, a grid, a legend, lines and marks.
#pragma once

#include <string>
#include <vector>

#include "tools/canvas.h"

namespace cliquevo::tools {

enum class Mark { none, disc, ring, square, cross };

struct Series {
  std::string label;  // empty: not in the legend
  std::vector<Point> points;
  Color color;
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

// Draws into parts of a figure, whose pixels are those of the finished picture.
class Figure {
 public:
  Figure(int width_px, int height_px, PictureFormat format = PictureFormat::png)
      : canvas_(width_px, height_px, format) {}
  void draw(const Chart& chart, Box area_px);
  // By its left end and middle line.
  void text(const std::string& text, Point at_px, double height_px, Color color) {
    canvas_.text(text, at_px, height_px, color);
  }
  Picture render() const { return canvas_.finish(); }
  Result<std::vector<unsigned char>> encoded() { return canvas_.encoded(); }

 private:
  Canvas canvas_;
};

}  // namespace cliquevo::tools
