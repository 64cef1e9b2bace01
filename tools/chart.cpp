// SPDX-License-Identifier: BSD-3-Clause
#include "tools/chart.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace cliquevo::tools {

namespace {

constexpr double kTickText = 13.0;
constexpr double kLabelText = 15.0;
constexpr double kTitleText = 18.0;

constexpr Color kInk{40, 40, 40};
constexpr Color kFaint{225, 225, 225};
constexpr Color kFrame{120, 120, 120};
constexpr Color kPaper{255, 255, 255};
constexpr Color kLegendFrame{200, 200, 200};

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();
  void include(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  double span() const { return high - low; }
  // Room around the data; never empty.
  void widen(double share, double at_least) {
    if (!(high >= low)) low = high = 0.0;
    const double room = std::max(share * span(), (at_least - span()) / 2);
    low -= room;
    high += room;
  }
};

void put_text_centred(Canvas& canvas, const std::string& text, Point middle, double height_px) {
  canvas.text(text, {middle.x - text_width(text, height_px) / 2.0, middle.y}, height_px, kInk);
}

// Reads from bottom to top.
void put_text_upright(Canvas& canvas, const std::string& text, Point middle, double height_px) {
  canvas.text(text, {middle.x, middle.y + text_width(text, height_px) / 2.0}, height_px, kInk, true);
}

void put_mark(Canvas& canvas, Point at, Mark mark, double r, Color color) {
  switch (mark) {
    case Mark::none:
      break;
    case Mark::disc:
      canvas.disc(at, r, color);
      break;
    case Mark::ring:
      canvas.ring(at, r, 2.0, color);
      break;
    case Mark::square:
      canvas.fill({at.x - r, at.y - r, 2 * r, 2 * r}, color);
      break;
    case Mark::cross:
      canvas.line(at - Point{r, r}, at + Point{r, r}, 2.0, color);
      canvas.line(at - Point{r, -r}, at + Point{r, -r}, 2.0, color);
      break;
  }
}

void put_series(Canvas& canvas, const Series& series, const std::vector<Point>& points) {
  if (series.width_px > 0.0) canvas.path(points, series.width_px, series.color, series.dashed);
  for (const Point& point : points) put_mark(canvas, point, series.mark, series.mark_px, series.color);
}

std::string tick_text(double value, const std::vector<double>& ticks) {
  const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0;
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
  return fmt::format("{:.{}f}", std::abs(value) < step * 1e-6 ? 0.0 : value, decimals);
}

// Where the data goes.
struct Layout {
  Box plot;
  Range x;
  Range y;
  std::vector<double> ticks_x;
  std::vector<double> ticks_y;
  Point to_canvas(Point p) const {
    return {plot.x + (p.x - x.low) / x.span() * plot.width, plot.bottom() - (p.y - y.low) / y.span() * plot.height};
  }
};

// Both axes get the scale of the tighter one; the data stays in the middle.
void equalise(Range& x, Range& y, double width_px, double height_px) {
  const double unit = std::max(x.span() / width_px, y.span() / height_px);
  x.widen(0.0, unit * width_px);
  y.widen(0.0, unit * height_px);
}

Layout lay_out(const Chart& chart, Box area_px, double left_px) {
  constexpr double kRight = 18.0;
  constexpr double kTop = 40.0;
  constexpr double kBottom = 62.0;
  Layout out;
  out.plot = {area_px.x + left_px, area_px.y + kTop, area_px.width - left_px - kRight, area_px.height - kTop - kBottom};
  for (const Series& series : chart.series) {
    for (const Point& p : series.points) {
      out.x.include(p.x);
      out.y.include(p.y);
    }
  }
  if (chart.from_zero) out.x.include(0.0);
  if (chart.from_zero) out.y.include(0.0);
  out.x.widen(chart.equal_aspect ? 0.06 : 0.0, 1e-3);
  out.y.widen(0.06, 1e-3);
  if (chart.from_zero) out.y.low = 0.0;
  if (chart.equal_aspect) equalise(out.x, out.y, out.plot.width, out.plot.height);
  // About one tick per 90 px across and 60 px up; squares where the axes are equal.
  const int across = std::max(2, static_cast<int>(out.plot.width / 90));
  const int up = std::max(2, static_cast<int>(out.plot.height / 60));
  out.ticks_x = tick_positions(out.x.low, out.x.high, across);
  out.ticks_y =
      tick_positions(out.y.low, out.y.high,
                     chart.equal_aspect ? std::max(2, static_cast<int>(across * out.y.span() / out.x.span())) : up);
  return out;
}

double widest_tick_px(const Layout& layout) {
  double widest = 0.0;
  for (const double tick : layout.ticks_y) {
    widest = std::max(widest, text_width(tick_text(tick, layout.ticks_y), kTickText));
  }
  return widest;
}

struct Size {
  double width;
  double height;
};

// Which corner of the chart holds the fewest points: the legend goes there.
Point legend_corner(const std::vector<std::vector<Point>>& lines, const Box& plot, Size size) {
  Point best;
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  constexpr double gap = 8.0;
  const double right = plot.right() - size.width - gap;
  const double bottom = plot.bottom() - size.height - gap;
  for (const Point corner : {Point{plot.x + gap, plot.y + gap}, Point{right, plot.y + gap}, Point{right, bottom},
                             Point{plot.x + gap, bottom}}) {
    const Box box{corner.x, corner.y, size.width, size.height};
    std::size_t inside = 0;
    for (const auto& line : lines) {
      inside +=
          static_cast<std::size_t>(std::count_if(line.begin(), line.end(), [&](auto p) { return box.contains(p); }));
    }
    if (inside < fewest) {
      fewest = inside;
      best = corner;
    }
  }
  return best;
}

void put_legend(Canvas& canvas, const Chart& chart, const std::vector<std::vector<Point>>& lines, const Box& plot) {
  constexpr double kRow = 24.0;
  constexpr double kSample = 34.0;
  constexpr double kPad = 10.0;
  std::vector<const Series*> named;
  double widest = 0.0;
  for (const Series& series : chart.series) {
    if (series.label.empty()) continue;
    named.push_back(&series);
    widest = std::max(widest, text_width(series.label, kTickText));
  }
  if (named.empty()) return;
  const Size size{kSample + widest + 3 * kPad, kRow * static_cast<double>(named.size()) + kPad};
  const Point corner = legend_corner(lines, plot, size);
  const Box box{corner.x, corner.y, size.width, size.height};
  canvas.fill(box, kPaper);
  canvas.frame(box, 1.0, kLegendFrame);
  for (std::size_t i = 0; i < named.size(); ++i) {
    const double y = corner.y + kPad / 2 + kRow * (static_cast<double>(i) + 0.5);
    const Point left{corner.x + kPad, y};
    const Point right{corner.x + kPad + kSample, y};
    Series sample = *named[i];
    const bool line = sample.width_px > 0.0;
    const Mark mark = sample.mark;
    sample.mark = Mark::none;
    if (line) put_series(canvas, sample, {left, right});
    put_mark(canvas, (left + right) * 0.5, mark, sample.mark_px, sample.color);
    canvas.text(sample.label, {right.x + kPad, y}, kTickText, kInk);
  }
}

}  // namespace

std::vector<double> tick_positions(double low, double high, int wanted) {
  std::vector<double> ticks;
  const double span = high - low;
  if (!(span > 0.0) || !std::isfinite(span) || wanted < 1) return ticks;
  const double rough = span / wanted;
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double step = power * (rough / power < 1.5 ? 1 : rough / power < 3.5 ? 2 : rough / power < 7.5 ? 5 : 10);
  for (double i = std::ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; ++i) ticks.push_back(i * step);
  return ticks;
}

void Figure::draw(const Chart& chart, Box area_px) {
  // Wide tick labels push the plot to the right, which may change the ticks of charts with equal axes.
  double left_px = 78.0;
  Layout layout = lay_out(chart, area_px, left_px);
  left_px = std::max(left_px, widest_tick_px(layout) + 46.0);
  layout = lay_out(chart, area_px, left_px);
  const Box& plot = layout.plot;

  for (const double tick : layout.ticks_x) {
    const double at = layout.to_canvas({tick, 0}).x;
    canvas_.line({at, plot.y}, {at, plot.bottom()}, 1.0, kFaint);
    put_text_centred(canvas_, tick_text(tick, layout.ticks_x), {at, plot.bottom() + 16.0}, kTickText);
  }
  for (const double tick : layout.ticks_y) {
    const double at = layout.to_canvas({0, tick}).y;
    canvas_.line({plot.x, at}, {plot.right(), at}, 1.0, kFaint);
    const std::string label = tick_text(tick, layout.ticks_y);
    canvas_.text(label, {plot.x - 8.0 - text_width(label, kTickText), at}, kTickText, kInk);
  }

  std::vector<std::vector<Point>> lines;
  for (const Series& series : chart.series) {
    auto& line = lines.emplace_back();
    for (const Point& p : series.points) line.push_back(layout.to_canvas(p));
    put_series(canvas_, series, line);
  }
  canvas_.frame(plot, 1.0, kFrame);
  put_legend(canvas_, chart, lines, plot);

  put_text_centred(canvas_, chart.title, {plot.x + plot.width / 2, plot.y - 20.0}, kTitleText);
  put_text_centred(canvas_, chart.x_label, {plot.x + plot.width / 2, plot.bottom() + 42.0}, kLabelText);
  put_text_upright(canvas_, chart.y_label, {area_px.x + 16, plot.y + plot.height / 2}, kLabelText);
}

}  // namespace cliquevo::tools
