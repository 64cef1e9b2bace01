// SPDX-License-Identifier: BSD-3-Clause
#include "tools/canvas.h"

#include <algorithm>
#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <cairo.h>
#include <cmath>
#include <string>

namespace cliquevo::tools {

namespace {

constexpr const char* kFont = "DejaVu Sans";  // what a fontconfig without it has for that is as good
constexpr double kCapital = 0.729;            // of that font's size
constexpr double kPdfScale = 0.5;             // points a pixel: a page's width

cairo_status_t append(void* bytes, const unsigned char* data, unsigned int size) {
  auto* out = static_cast<std::vector<unsigned char>*>(bytes);
  out->insert(out->end(), data, data + size);
  return CAIRO_STATUS_SUCCESS;
}

// Cairo draws nothing any more once it was given text that is no UTF-8, or a control character in an SVG.
std::string drawable(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const auto c = static_cast<unsigned char>(text[i]);
    const std::size_t length = c < 0x80 ? 1 : c >= 0xC2 && c < 0xE0 ? 2 : c >= 0xE0 && c < 0xF0 ? 3 : 0;
    bool good = length > 0 && i + length <= text.size() && c >= 0x20 && c != 0x7F;
    for (std::size_t k = 1; good && k < length; ++k) good = (static_cast<unsigned char>(text[i + k]) & 0xC0) == 0x80;
    if (good && c == 0xE0) good = static_cast<unsigned char>(text[i + 1]) >= 0xA0;
    if (good && c == 0xED) good = static_cast<unsigned char>(text[i + 1]) < 0xA0;
    out += good ? text.substr(i, length) : std::string_view("?");
    i += good ? length : 1;
  }
  return out;
}

void set_font(cairo_t* cairo, double height) {
  cairo_select_font_face(cairo, kFont, CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(cairo, height / kCapital);
  // The same widths in every format, upright as along.
  cairo_font_options_t* options = cairo_font_options_create();
  cairo_font_options_set_hint_style(options, CAIRO_HINT_STYLE_NONE);
  cairo_font_options_set_hint_metrics(options, CAIRO_HINT_METRICS_OFF);
  cairo_font_options_set_antialias(options, CAIRO_ANTIALIAS_GRAY);
  cairo_set_font_options(cairo, options);
  cairo_font_options_destroy(options);
}

bool finite(Point p) { return std::isfinite(p.x + p.y); }
// Cairo counts in fixed point: what lies far outside is brought near, which nobody sees.
Point near(Point p) { return {std::clamp(p.x, -1e4, 1e4), std::clamp(p.y, -1e4, 1e4)}; }

}  // namespace

struct Canvas::Impl {
  PictureFormat format;
  int width;
  int height;
  std::vector<unsigned char> bytes;
  cairo_surface_t* surface = nullptr;
  cairo_t* cairo = nullptr;

  void color(Color c) { cairo_set_source_rgb(cairo, c.red / 255.0, c.green / 255.0, c.blue / 255.0); }
};

Canvas::Canvas(int width, int height, PictureFormat format) : impl_(new Impl{format, width, height, {}}) {
  Impl& m = *impl_;
  const double scale = format == PictureFormat::pdf ? kPdfScale : 1.0;
  if (format == PictureFormat::svg) {
    m.surface = cairo_svg_surface_create_for_stream(append, &m.bytes, width, height);
    cairo_svg_surface_set_document_unit(m.surface, CAIRO_SVG_UNIT_PX);
  } else if (format == PictureFormat::pdf) {
    m.surface = cairo_pdf_surface_create_for_stream(append, &m.bytes, width * scale, height * scale);
    cairo_pdf_surface_set_metadata(m.surface, CAIRO_PDF_METADATA_CREATE_DATE, "1970-01-01T00:00:00Z");
  } else {
    m.surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, width, height);
  }
  m.cairo = cairo_create(m.surface);
  cairo_scale(m.cairo, scale, scale);
  fill({0, 0, static_cast<double>(width), static_cast<double>(height)}, {255, 255, 255});
  cairo_set_line_cap(m.cairo, CAIRO_LINE_CAP_ROUND);
  cairo_set_line_join(m.cairo, CAIRO_LINE_JOIN_ROUND);
}

Canvas::~Canvas() {
  cairo_destroy(impl_->cairo);
  cairo_surface_destroy(impl_->surface);
}

void Canvas::line(Point a, Point b, double width, Color color) { path({a, b}, width, color, false); }

void Canvas::path(const std::vector<Point>& points, double width, Color color, bool dashed) {
  if (points.empty() || !std::all_of(points.begin(), points.end(), finite)) return;
  Impl& m = *impl_;
  m.color(color);
  cairo_set_line_width(m.cairo, width);
  const double dashes[] = {9.0, 6.0 + width};
  cairo_set_dash(m.cairo, dashes, dashed ? 2 : 0, 0.0);
  cairo_new_path(m.cairo);
  for (const Point& p : points) cairo_line_to(m.cairo, near(p).x, near(p).y);
  if (points.size() == 1) cairo_line_to(m.cairo, near(points[0]).x, near(points[0]).y);
  cairo_stroke(m.cairo);
}

void Canvas::disc(Point middle, double radius, Color color) {
  if (!finite(middle)) return;
  Impl& m = *impl_;
  m.color(color);
  cairo_new_path(m.cairo);
  cairo_arc(m.cairo, near(middle).x, near(middle).y, radius, 0.0, 2.0 * M_PI);
  cairo_fill(m.cairo);
}

void Canvas::ring(Point middle, double radius, double width, Color color) {
  disc(middle, radius + width / 2, color);
  disc(middle, radius - width / 2, {255, 255, 255});
}

void Canvas::fill(Box box, Color color) {
  Impl& m = *impl_;
  m.color(color);
  cairo_new_path(m.cairo);
  cairo_rectangle(m.cairo, box.x, box.y, box.width, box.height);
  cairo_fill(m.cairo);
}

void Canvas::frame(Box box, double width, Color color) {
  const double h = width / 2;
  fill({box.x - h, box.y - h, box.width + width, width}, color);
  fill({box.x - h, box.bottom() - h, box.width + width, width}, color);
  fill({box.x - h, box.y - h, width, box.height + width}, color);
  fill({box.right() - h, box.y - h, width, box.height + width}, color);
}

void Canvas::text(std::string_view text, Point start, double height, Color color, bool upright) {
  Impl& m = *impl_;
  m.color(color);
  cairo_save(m.cairo);
  set_font(m.cairo, height);
  cairo_translate(m.cairo, start.x, start.y);
  if (upright) cairo_rotate(m.cairo, -M_PI / 2.0);
  cairo_move_to(m.cairo, 0.0, height / 2.0);
  cairo_show_text(m.cairo, drawable(text).c_str());
  cairo_restore(m.cairo);
}

double text_width(std::string_view text, double height) {
  cairo_surface_t* surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, 1, 1);
  cairo_t* cairo = cairo_create(surface);
  set_font(cairo, height);
  cairo_text_extents_t extents{};
  cairo_text_extents(cairo, drawable(text).c_str(), &extents);
  cairo_destroy(cairo);
  cairo_surface_destroy(surface);
  return extents.x_advance;
}

Picture Canvas::finish() const {
  const Impl& m = *impl_;
  Picture out(m.width, m.height, {255, 255, 255});
  if (m.format != PictureFormat::png) return out;
  cairo_surface_flush(m.surface);
  const unsigned char* pixels = cairo_image_surface_get_data(m.surface);
  const int stride = cairo_image_surface_get_stride(m.surface);
  for (int y = 0; y < m.height; ++y) {
    const auto* row = reinterpret_cast<const std::uint32_t*>(pixels + static_cast<std::ptrdiff_t>(y) * stride);
    for (int x = 0; x < m.width; ++x) {
      out.set(x, y,
              {static_cast<std::uint8_t>(row[x] >> 16U), static_cast<std::uint8_t>(row[x] >> 8U),
               static_cast<std::uint8_t>(row[x])});
    }
  }
  return out;
}

Result<std::vector<unsigned char>> Canvas::encoded() {
  Impl& m = *impl_;
  if (cairo_status(m.cairo) != CAIRO_STATUS_SUCCESS) {
    return Error{"cannot draw", "the picture", cairo_status_to_string(cairo_status(m.cairo))};
  }
  if (m.format == PictureFormat::png) return finish().png();
  cairo_surface_finish(m.surface);
  return m.bytes;
}

}  // namespace cliquevo::tools
