// SPDX-License-Identifier: BSD-3-Clause
// What charts are drawn with, by Cairo: lines, discs, boxes and text, into a PNG, an SVG or a PDF.
#pragma once

#include <memory>
#include <string_view>
#include <vector>

#include "core/base/result.h"
#include "tools/picture.h"
#include "tools/picture_format.h"

namespace cliquevo::tools {

struct Point {
  double x = 0.0;
  double y = 0.0;
};
inline Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y}; }
inline Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y}; }
inline Point operator*(Point a, double s) { return {a.x * s, a.y * s}; }

struct Box {
  double x = 0.0;
  double y = 0.0;
  double width = 0.0;
  double height = 0.0;
  double right() const { return x + width; }
  double bottom() const { return y + height; }
  bool contains(Point p) const { return p.x >= x && p.x < right() && p.y >= y && p.y < bottom(); }
};

// All lengths are pixels of the finished picture, Y downwards.
class Canvas {
 public:
  Canvas(int width, int height, PictureFormat format = PictureFormat::png);
  ~Canvas();
  Canvas(const Canvas&) = delete;
  Canvas& operator=(const Canvas&) = delete;

  void line(Point a, Point b, double width, Color color);  // with round ends
  void path(const std::vector<Point>& points, double width, Color color, bool dashed);
  void disc(Point middle, double radius, Color color);
  void ring(Point middle, double radius, double width, Color color);  // the radius is that of the line's middle
  void fill(Box box, Color color);
  void frame(Box box, double width, Color color);
  // UTF-8; `height` is that of a capital. By the text's left end (upright: its lower one) and middle line.
  void text(std::string_view text, Point start, double height, Color color, bool upright = false);

  // The pixels; of a PNG alone.
  Picture finish() const;
  // The file's bytes; nothing can be drawn afterwards.
  Result<std::vector<unsigned char>> encoded();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

double text_width(std::string_view text, double height);

}  // namespace cliquevo::tools
