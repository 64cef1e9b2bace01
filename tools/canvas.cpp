// SPDX-License-Identifier: BSD-3-Clause
#include "tools/canvas.h"

#include <algorithm>
#include <cmath>

#include "tools/stroke_font.h"

namespace cliquevo::tools {

namespace {

constexpr int kOversampling = 3;
constexpr double kStroke = 1.0 / 9.5;  // of letters, beside the height of a capital
constexpr double kLetterGap = 2.0;     // the font's units

double distance(Point p, Point a, Point b) {
  const Point way = b - a;
  const double length2 = way.x * way.x + way.y * way.y;
  const Point to = p - a;
  const double s = length2 > 0.0 ? std::clamp((to.x * way.x + to.y * way.y) / length2, 0.0, 1.0) : 0.0;
  return std::hypot(to.x - s * way.x, to.y - s * way.y);
}

int first_row(double y) { return std::max(0, static_cast<int>(std::ceil(y - 0.5))); }

}  // namespace

Canvas::Canvas(int width, int height) : large_(width * kOversampling, height * kOversampling, {255, 255, 255}) {}

void Canvas::set(int x, int y, Color color) {
  if (x >= 0 && y >= 0 && x < large_.width() && y < large_.height()) large_.set(x, y, color);
}

void Canvas::line(Point a, Point b, double width, Color color) {
  if (!std::isfinite(a.x + a.y + b.x + b.y)) return;
  a = a * kOversampling, b = b * kOversampling;
  const double r = std::max(0.5, width * kOversampling / 2.0);
  if (a.y > b.y) std::swap(a, b);
  const double slope = b.y > a.y ? (b.x - a.x) / (b.y - a.y) : 0.0;
  const double last = std::min<double>(large_.height() - 1, b.y + r);
  for (int y = first_row(a.y - r); y <= last; ++y) {
    // Only the part of the line that is near this row.
    const double middle = y + 0.5;
    double left = std::min(a.x, b.x);
    double right = std::max(a.x, b.x);
    if (b.y > a.y) {
      const double x1 = a.x + slope * (std::clamp(middle - r, a.y, b.y) - a.y);
      const double x2 = a.x + slope * (std::clamp(middle + r, a.y, b.y) - a.y);
      left = std::min(x1, x2), right = std::max(x1, x2);
    }
    const int from = static_cast<int>(std::max(0.0, left - r - 1.0));
    const int to = static_cast<int>(std::min<double>(large_.width() - 1, right + r + 1.0));
    for (int x = from; x <= to; ++x) {
      if (distance({x + 0.5, middle}, a, b) <= r) large_.set(x, y, color);
    }
  }
}

void Canvas::disc(Point middle, double radius, Color color) { line(middle, middle, 2 * radius, color); }

void Canvas::ring(Point middle, double radius, double width, Color color) {
  disc(middle, radius + width / 2, color);
  disc(middle, radius - width / 2, {255, 255, 255});
}

void Canvas::fill(Box box, Color color) {
  const auto edge = [](double v, int most) {
    return std::clamp(static_cast<int>(std::lround(v * kOversampling)), 0, most);
  };
  for (int y = edge(box.y, large_.height()); y < edge(box.bottom(), large_.height()); ++y) {
    for (int x = edge(box.x, large_.width()); x < edge(box.right(), large_.width()); ++x) large_.set(x, y, color);
  }
}

void Canvas::frame(Box box, double width, Color color) {
  const double h = width / 2;
  fill({box.x - h, box.y - h, box.width + width, width}, color);
  fill({box.x - h, box.bottom() - h, box.width + width, width}, color);
  fill({box.x - h, box.y - h, width, box.height + width}, color);
  fill({box.right() - h, box.y - h, width, box.height + width}, color);
}

void Canvas::text(std::string_view text, Point start, double height, Color color, bool upright) {
  const double unit = height / kCapitalHeight;
  double at = 0.0;
  for (const char c : text) {
    const Glyph glyph = glyph_of(c);
    const auto place = [&](GlyphPoint p) {
      const double along = (at + p.x) * unit;
      const double down = (kCapitalHeight / 2.0 - p.y) * unit;
      return upright ? Point{start.x + down, start.y - along} : Point{start.x + along, start.y + down};
    };
    for (const auto& [a, b] : strokes_of(glyph)) line(place(a), place(b), height * kStroke, color);
    at += glyph.width + kLetterGap;
  }
}

double text_width(std::string_view text, double height) {
  double units = 0.0;
  for (const char c : text) units += glyph_of(c).width + kLetterGap;
  return std::max(0.0, units - kLetterGap) * height / kCapitalHeight;
}

Picture Canvas::finish() const {
  return large_.shrunk(large_.width() / kOversampling, large_.height() / kOversampling);
}

}  // namespace cliquevo::tools
