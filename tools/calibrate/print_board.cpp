// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/print_board.h"

#include <apriltag/apriltag.h>
#include <apriltag/tag36h11.h>
#include <cairo-pdf.h>
#include <cairo-svg.h>
#include <cairo.h>
#include <cmath>
#include <memory>

#include <fmt/format.h>
#include <opencv2/aruco.hpp>

#include "tools/calibrate/markers.h"

namespace cliquevo::tools {

namespace {

using calibration::Board;
using calibration::BoardKind;

constexpr double kPointsPerMetre = 72.0 / 0.0254;
constexpr double kBorder_m = 0.015;
constexpr double kRulerRoom_m = 0.02;
constexpr double kRuler_m = 0.1;
constexpr double kMostPage_m = 3.0;
constexpr double kDotOfDistance = 0.5;  // diameter of a dot over the distance of neighbours

struct Close {
  void operator()(cairo_surface_t* s) const { cairo_surface_destroy(s); }
  void operator()(cairo_t* c) const { cairo_destroy(c); }
};
using Surface = std::unique_ptr<cairo_surface_t, Close>;
using Context = std::unique_ptr<cairo_t, Close>;

// Draws in metres, Y downwards, from the board's upper left.
class Page {
 public:
  explicit Page(cairo_t* context) : context_(context) {}

  void square(double x, double y, double side) {
    cairo_rectangle(context_, x, y, side, side);
    cairo_fill(context_);
  }
  void dot(double x, double y, double radius) {
    cairo_arc(context_, x, y, radius, 0.0, 2.0 * M_PI);
    cairo_fill(context_);
  }
  // White cells on a black square; those side by side in one piece, so that no hair line is between them.
  void cells(double x, double y, double side, const MarkerCells& cells) {
    const double cell = side / cells.across;
    square(x, y, side);
    cairo_set_source_rgb(context_, 1.0, 1.0, 1.0);
    const auto white = [&](int column, int row) {
      return column < cells.across && row < cells.across && !cells.black(column, row);
    };
    for (int row = 0; row < cells.across; ++row) {
      for (int column = 0; column < cells.across; ++column) {
        if (!white(column, row)) continue;
        cairo_rectangle(context_, x + column * cell, y + row * cell, cell * (white(column + 1, row) ? 2 : 1), cell);
        cairo_rectangle(context_, x + column * cell, y + row * cell, cell, cell * (white(column, row + 1) ? 2 : 1));
      }
    }
    cairo_fill(context_);
    cairo_set_source_rgb(context_, 0.0, 0.0, 0.0);
  }
  void text(double x, double y, double height, const std::string& words) {
    cairo_set_font_size(context_, height);
    cairo_move_to(context_, x, y);
    cairo_show_text(context_, words.c_str());
  }
  void ruler(double x, double y) {
    constexpr int kMarks = 10;
    for (int i = 0; i <= kMarks; ++i) {
      cairo_rectangle(context_, x + kRuler_m * i / kMarks - 0.0001, y, 0.0002, i % 5 == 0 ? 0.005 : 0.003);
    }
    cairo_rectangle(context_, x, y, kRuler_m, 0.0002);
    cairo_fill(context_);
  }

 private:
  cairo_t* context_;
};

struct Extent {
  double width = 0.0;
  double height = 0.0;
};

Extent extent_of(const Board& b) {
  switch (b.kind) {
    case BoardKind::chessboard:
      return {b.size_m * (b.columns + 1), b.size_m * (b.rows + 1)};
    case BoardKind::charuco:
      return {b.size_m * b.columns, b.size_m * b.rows};
    case BoardKind::aprilgrid:
      return {b.size_m * (b.columns + (b.columns + 1) * b.ratio), b.size_m * (b.rows + (b.rows + 1) * b.ratio)};
    case BoardKind::circles:
      break;
  }
  return {b.size_m * b.columns, b.size_m * b.rows};
}

void draw_squares(const Board& b, Page& page, int columns, int rows) {
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      if ((row + column) % 2 == 0) page.square(b.size_m * column, b.size_m * row, b.size_m);
    }
  }
}

void draw_charuco(const Board& b, Page& page) {
  draw_squares(b, page, b.columns, b.rows);
  const double side = b.size_m * b.ratio;
  const double margin = 0.5 * (b.size_m - side);
  int id = 0;
  for (int row = 0; row < b.rows; ++row) {
    for (int column = 0; column < b.columns; ++column) {
      if ((row + column) % 2 == 0) continue;
      page.cells(b.size_m * column + margin, b.size_m * row + margin, side, aruco_marker(b, id++));
    }
  }
}

// As Kalibr prints it: a small black square where the corners of four tags meet.
void draw_aprilgrid(const Board& b, Page& page) {
  const double gap = b.size_m * b.ratio;
  const double step = b.size_m + gap;
  const double height = extent_of(b).height;
  for (int row = 0; row <= b.rows; ++row) {
    for (int column = 0; column <= b.columns; ++column) page.square(column * step, row * step, gap);
  }
  for (int id = 0; id < b.columns * b.rows; ++id) {
    const double x = gap + (id % b.columns) * step;
    const int row = id / b.columns;
    const double y = height - gap - b.size_m - row * step;
    page.cells(x, y, b.size_m, april_tag(id));
  }
}

void draw(const Board& b, Page& page) {
  switch (b.kind) {
    case BoardKind::chessboard:
      draw_squares(b, page, b.columns + 1, b.rows + 1);
      return;
    case BoardKind::charuco:
      draw_charuco(b, page);
      return;
    case BoardKind::aprilgrid:
      draw_aprilgrid(b, page);
      return;
    case BoardKind::circles:
      break;
  }
  for (int row = 0; row < b.rows; ++row) {
    for (int column = 0; column < b.columns; ++column) {
      page.dot(b.size_m * (column + 0.5), b.size_m * (row + 0.5), 0.5 * kDotOfDistance * b.size_m);
    }
  }
}

}  // namespace

Result<void> print_board(const Board& board, const std::string& path) {
  const bool pdf = path.ends_with(".pdf");
  if (!pdf && !path.ends_with(".svg")) return Error{"cannot write board", path, "name it FILE.pdf or FILE.svg"};
  const Extent board_extent = extent_of(board);
  const double width_m = std::max(board_extent.width, kRuler_m) + 2.0 * kBorder_m;
  const double height_m = board_extent.height + 2.0 * kBorder_m + kRulerRoom_m;
  if (std::max(width_m, height_m) > kMostPage_m) {
    return Error{"cannot write board", path,
                 fmt::format("it would be {:.1f} x {:.1f} m: name a smaller one", width_m, height_m)};
  }
  const double width = width_m * kPointsPerMetre;
  const double height = height_m * kPointsPerMetre;
  const Surface surface(pdf ? cairo_pdf_surface_create(path.c_str(), width, height)
                            : cairo_svg_surface_create(path.c_str(), width, height));
  if (!pdf && cairo_surface_status(surface.get()) == CAIRO_STATUS_SUCCESS) {
    cairo_svg_surface_set_document_unit(surface.get(), CAIRO_SVG_UNIT_PT);
  }
  const Context context(cairo_create(surface.get()));
  cairo_set_source_rgb(context.get(), 1.0, 1.0, 1.0);
  cairo_paint(context.get());
  cairo_set_source_rgb(context.get(), 0.0, 0.0, 0.0);
  cairo_scale(context.get(), kPointsPerMetre, kPointsPerMetre);
  cairo_translate(context.get(), kBorder_m, kBorder_m);
  Page page(context.get());
  draw(board, page);
  const double below = board_extent.height + 0.5 * kBorder_m;
  page.ruler(0.0, below + 0.006);
  page.text(0.0, below + 0.017, 0.004, fmt::format("{}   this ruler is 100 mm long", board.text()));
  cairo_surface_finish(surface.get());
  for (const cairo_status_t status : {cairo_status(context.get()), cairo_surface_status(surface.get())}) {
    if (status != CAIRO_STATUS_SUCCESS) return Error{"cannot write board", path, cairo_status_to_string(status)};
  }
  return {};
}

}  // namespace cliquevo::tools
