// SPDX-License-Identifier: BSD-3-Clause
#include "tools/chart.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

namespace cliquevo::tools {

namespace {

constexpr int kOversampling = 3;
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kFontCapHeight = 21.0;  // px at scale 1
constexpr double kTickText = 13.0;
constexpr double kLabelText = 15.0;
constexpr double kTitleText = 18.0;
constexpr int kShift = 4;  // OpenCV draws to 1/16 px

const cv::Scalar kInk(40, 40, 40);
const cv::Scalar kFaint(225, 225, 225);
const cv::Scalar kFrame(120, 120, 120);

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

double text_scale(double height_px) { return height_px * kOversampling / kFontCapHeight; }
int text_thickness(double height_px) {
  return std::max(1, static_cast<int>(std::lround(height_px * kOversampling / 9.5)));
}

cv::Size text_size(const std::string& text, double height_px) {
  int baseline = 0;
  return cv::getTextSize(text, kFont, text_scale(height_px), text_thickness(height_px), &baseline);
}

// Text by its left end and middle line; canvas px.
void put_text(cv::Mat& canvas, const std::string& text, cv::Point2d left_middle, double height_px,
              const cv::Scalar& color) {
  const cv::Size size = text_size(text, height_px);
  cv::putText(
      canvas, text,
      {static_cast<int>(std::lround(left_middle.x)), static_cast<int>(std::lround(left_middle.y + size.height / 2.0))},
      kFont, text_scale(height_px), color, text_thickness(height_px), cv::LINE_AA);
}

void put_text_centred(cv::Mat& canvas, const std::string& text, cv::Point2d middle, double height_px,
                      const cv::Scalar& color) {
  put_text(canvas, text, {middle.x - text_size(text, height_px).width / 2.0, middle.y}, height_px, color);
}

// Reads from bottom to top.
void put_text_upright(cv::Mat& canvas, const std::string& text, cv::Point2d middle, double height_px,
                      const cv::Scalar& color) {
  const cv::Size size = text_size(text, height_px);
  cv::Mat strip(2 * size.height, size.width + 8, CV_8UC3, cv::Scalar::all(255));
  put_text_centred(strip, text, {strip.cols / 2.0, strip.rows / 2.0}, height_px, color);
  cv::rotate(strip, strip, cv::ROTATE_90_COUNTERCLOCKWISE);
  const cv::Rect place(static_cast<int>(middle.x - strip.cols / 2.0), static_cast<int>(middle.y - strip.rows / 2.0),
                       strip.cols, strip.rows);
  const cv::Rect inside = place & cv::Rect(0, 0, canvas.cols, canvas.rows);
  strip(inside - place.tl()).copyTo(canvas(inside));
}

cv::Point fixed_point(cv::Point2d p) {
  constexpr double kScale = 1 << kShift;
  return {static_cast<int>(std::lround(p.x * kScale)), static_cast<int>(std::lround(p.y * kScale))};
}

void put_line(cv::Mat& canvas, cv::Point2d a, cv::Point2d b, double width_px, const cv::Scalar& color) {
  const int thickness = std::max(1, static_cast<int>(std::lround(width_px * kOversampling)));
  cv::line(canvas, fixed_point(a), fixed_point(b), color, thickness, cv::LINE_AA, kShift);
}

void put_mark(cv::Mat& canvas, cv::Point2d at, Mark mark, double half_px, const cv::Scalar& color) {
  const double r = half_px * kOversampling;
  switch (mark) {
    case Mark::none:
      break;
    case Mark::disc:
      cv::circle(canvas, fixed_point(at), static_cast<int>(r * (1 << kShift)), color, cv::FILLED, cv::LINE_AA, kShift);
      break;
    case Mark::ring:
      cv::circle(canvas, fixed_point(at), static_cast<int>(r * (1 << kShift)), cv::Scalar::all(255), cv::FILLED,
                 cv::LINE_AA, kShift);
      cv::circle(canvas, fixed_point(at), static_cast<int>(r * (1 << kShift)), color, 2 * kOversampling, cv::LINE_AA,
                 kShift);
      break;
    case Mark::square:
      cv::rectangle(canvas, fixed_point(at - cv::Point2d(r, r)), fixed_point(at + cv::Point2d(r, r)), color, cv::FILLED,
                    cv::LINE_AA, kShift);
      break;
    case Mark::cross:
      put_line(canvas, at - cv::Point2d(r, r), at + cv::Point2d(r, r), 2.0, color);
      put_line(canvas, at - cv::Point2d(r, -r), at + cv::Point2d(r, -r), 2.0, color);
      break;
  }
}

// Dashes run on over the corners of the line.
void put_dashed(cv::Mat& canvas, const std::vector<cv::Point2d>& points, double width_px, const cv::Scalar& color) {
  constexpr double kDash = 9.0 * kOversampling;
  constexpr double kGap = 6.0 * kOversampling;
  double phase = 0.0;
  for (std::size_t i = 0; i + 1 < points.size(); ++i) {
    const cv::Point2d way = points[i + 1] - points[i];
    const double length = cv::norm(way);
    for (double at = 0.0; at < length;) {
      const bool drawn = phase < kDash;
      const double step = std::min(length - at, (drawn ? kDash : kDash + kGap) - phase);
      if (drawn) {
        put_line(canvas, points[i] + way * (at / length), points[i] + way * ((at + step) / length), width_px, color);
      }
      at += step;
      phase += step;
      if (phase >= kDash + kGap - 1e-9) phase = 0.0;
      if (step <= 0.0) break;
    }
  }
}

void put_series(cv::Mat& canvas, const Series& series, const std::vector<cv::Point2d>& points) {
  if (series.width_px > 0.0 && series.dashed) put_dashed(canvas, points, series.width_px, series.color);
  if (series.width_px > 0.0 && !series.dashed) {
    for (std::size_t i = 0; i + 1 < points.size(); ++i) {
      put_line(canvas, points[i], points[i + 1], series.width_px, series.color);
    }
  }
  for (const cv::Point2d& point : points) put_mark(canvas, point, series.mark, series.mark_px, series.color);
}

std::string tick_text(double value, const std::vector<double>& ticks) {
  const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : 1.0;
  const int decimals = std::clamp(static_cast<int>(std::ceil(-std::log10(step) - 1e-9)), 0, 9);
  return fmt::format("{:.{}f}", std::abs(value) < step * 1e-6 ? 0.0 : value, decimals);
}

// Where the data goes; canvas px.
struct Layout {
  cv::Rect2d plot;
  Range x;
  Range y;
  std::vector<double> ticks_x;
  std::vector<double> ticks_y;
  cv::Point2d to_canvas(cv::Point2d p) const {
    return {plot.x + (p.x - x.low) / x.span() * plot.width, plot.br().y - (p.y - y.low) / y.span() * plot.height};
  }
};

// Both axes get the scale of the tighter one; the data stays in the middle.
void equalise(Range& x, Range& y, double width_px, double height_px) {
  const double unit = std::max(x.span() / width_px, y.span() / height_px);
  x.widen(0.0, unit * width_px);
  y.widen(0.0, unit * height_px);
}

Layout lay_out(const Chart& chart, cv::Rect2d area_px, double left_px) {
  constexpr double kRight = 18.0;
  constexpr double kTop = 40.0;
  constexpr double kBottom = 62.0;
  constexpr double s = kOversampling;
  Layout out;
  out.plot = {(area_px.x + left_px) * s, (area_px.y + kTop) * s, (area_px.width - left_px - kRight) * s,
              (area_px.height - kTop - kBottom) * s};
  for (const Series& series : chart.series) {
    for (const cv::Point2d& p : series.points) {
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
  const int across = std::max(2, static_cast<int>(out.plot.width / s / 90));
  const int up = std::max(2, static_cast<int>(out.plot.height / s / 60));
  out.ticks_x = tick_positions(out.x.low, out.x.high, across);
  out.ticks_y =
      tick_positions(out.y.low, out.y.high,
                     chart.equal_aspect ? std::max(2, static_cast<int>(across * out.y.span() / out.x.span())) : up);
  return out;
}

double widest_tick_px(const Layout& layout) {
  int widest = 0;
  for (const double tick : layout.ticks_y) {
    widest = std::max(widest, text_size(tick_text(tick, layout.ticks_y), kTickText).width);
  }
  return widest / static_cast<double>(kOversampling);
}

// Which corner of the chart holds the fewest points: the legend goes there.
cv::Point2d legend_corner(const std::vector<std::vector<cv::Point2d>>& lines, const cv::Rect2d& plot, cv::Size2d size) {
  cv::Point2d best;
  std::size_t fewest = std::numeric_limits<std::size_t>::max();
  const double gap = 8.0 * kOversampling;
  for (const cv::Point2d corner :
       {cv::Point2d(plot.x + gap, plot.y + gap), cv::Point2d(plot.br().x - size.width - gap, plot.y + gap),
        cv::Point2d(plot.br().x - size.width - gap, plot.br().y - size.height - gap),
        cv::Point2d(plot.x + gap, plot.br().y - size.height - gap)}) {
    const cv::Rect2d box(corner, size);
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

void put_legend(cv::Mat& canvas, const Chart& chart, const std::vector<std::vector<cv::Point2d>>& lines,
                const cv::Rect2d& plot) {
  constexpr double kRow = 24.0 * kOversampling;
  constexpr double kSample = 34.0 * kOversampling;
  constexpr double kPad = 10.0 * kOversampling;
  std::vector<const Series*> named;
  double widest = 0.0;
  for (const Series& series : chart.series) {
    if (series.label.empty()) continue;
    named.push_back(&series);
    widest = std::max<double>(widest, text_size(series.label, kTickText).width);
  }
  if (named.empty()) return;
  const cv::Size2d size(kSample + widest + 3 * kPad, kRow * static_cast<double>(named.size()) + kPad);
  const cv::Point2d corner = legend_corner(lines, plot, size);
  const cv::Rect box(corner, size);
  cv::rectangle(canvas, box, cv::Scalar::all(255), cv::FILLED);
  cv::rectangle(canvas, box, cv::Scalar::all(200), kOversampling, cv::LINE_AA);
  for (std::size_t i = 0; i < named.size(); ++i) {
    const double y = corner.y + kPad / 2 + kRow * (static_cast<double>(i) + 0.5);
    const cv::Point2d left(corner.x + kPad, y);
    const cv::Point2d right(corner.x + kPad + kSample, y);
    Series sample = *named[i];
    const bool line = sample.width_px > 0.0;
    const Mark mark = sample.mark;
    sample.mark = Mark::none;
    if (line) put_series(canvas, sample, {left, right});
    put_mark(canvas, (left + right) / 2, mark, sample.mark_px, sample.color);
    put_text(canvas, sample.label, {right.x + kPad, y}, kTickText, kInk);
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

Figure::Figure(int width_px, int height_px)
    : canvas_(height_px * kOversampling, width_px * kOversampling, CV_8UC3, cv::Scalar::all(255)) {}

void Figure::text(const std::string& text, cv::Point2d at_px, double height_px, const cv::Scalar& color) {
  put_text(canvas_, text, at_px * kOversampling, height_px, color);
}

void Figure::draw(const Chart& chart, cv::Rect2d area_px) {
  // Wide tick labels push the plot to the right, which may change the ticks of charts with equal axes.
  double left_px = 78.0;
  Layout layout = lay_out(chart, area_px, left_px);
  left_px = std::max(left_px, widest_tick_px(layout) + 46.0);
  layout = lay_out(chart, area_px, left_px);
  const cv::Rect2d& plot = layout.plot;
  constexpr double s = kOversampling;

  for (const double tick : layout.ticks_x) {
    const double at = layout.to_canvas({tick, 0}).x;
    put_line(canvas_, {at, plot.y}, {at, plot.br().y}, 1.0, kFaint);
    put_text_centred(canvas_, tick_text(tick, layout.ticks_x), {at, plot.br().y + 16 * s}, kTickText, kInk);
  }
  for (const double tick : layout.ticks_y) {
    const double at = layout.to_canvas({0, tick}).y;
    put_line(canvas_, {plot.x, at}, {plot.br().x, at}, 1.0, kFaint);
    const std::string label = tick_text(tick, layout.ticks_y);
    put_text(canvas_, label, {plot.x - 8 * s - text_size(label, kTickText).width, at}, kTickText, kInk);
  }

  std::vector<std::vector<cv::Point2d>> lines;
  for (const Series& series : chart.series) {
    auto& line = lines.emplace_back();
    for (const cv::Point2d& p : series.points) line.push_back(layout.to_canvas(p));
    put_series(canvas_, series, line);
  }
  cv::rectangle(canvas_, cv::Rect(plot), kFrame, kOversampling, cv::LINE_AA);
  put_legend(canvas_, chart, lines, plot);

  put_text_centred(canvas_, chart.title, {plot.x + plot.width / 2, plot.y - 20 * s}, kTitleText, kInk);
  put_text_centred(canvas_, chart.x_label, {plot.x + plot.width / 2, plot.br().y + 42 * s}, kLabelText, kInk);
  put_text_upright(canvas_, chart.y_label, {(area_px.x + 16) * s, plot.y + plot.height / 2}, kLabelText, kInk);
}

cv::Mat Figure::render() const {
  cv::Mat out;
  cv::resize(canvas_, out, {canvas_.cols / kOversampling, canvas_.rows / kOversampling}, 0, 0, cv::INTER_AREA);
  return out;
}

}  // namespace cliquevo::tools
