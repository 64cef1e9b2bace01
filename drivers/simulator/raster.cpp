// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/raster.h"

#include <algorithm>
#include <cmath>

#include "drivers/simulator/image_rectangle.h"
#include "drivers/simulator/texture.h"

namespace cliquevo::drivers::sim {

namespace {

struct Corner {
  double u, v;
};

// Pixels whose sample lies inside; an edge that two triangles share gives both the same crossing, so that nothing is
// left open and nothing is drawn twice.
template <typename Span>
void scan_triangle(Corner a, Corner b, Corner c, int width, int height, Span&& span) {
  const auto before = [](const Corner& p, const Corner& q) { return p.v < q.v || (p.v == q.v && p.u < q.u); };
  if (before(b, a)) std::swap(a, b);
  if (before(c, b)) std::swap(b, c);
  if (before(b, a)) std::swap(a, b);
  if (!(c.v >= 0.0) || !(a.v <= height - 1)) return;
  const int j0 = std::max(static_cast<int>(std::ceil(a.v)), 0);
  const int j1 = static_cast<int>(std::ceil(std::min(c.v, static_cast<double>(height)))) - 1;
  if (j0 > j1) return;
  const double long_slope = (c.u - a.u) / (c.v - a.v);
  const double first_slope = b.v > a.v ? (b.u - a.u) / (b.v - a.v) : 0.0;
  const double second_slope = c.v > b.v ? (c.u - b.u) / (c.v - b.v) : 0.0;
  for (int j = j0; j <= std::min(j1, height - 1); ++j) {
    double x0 = a.u + (j - a.v) * long_slope;
    double x1 = j < b.v ? a.u + (j - a.v) * first_slope : b.u + (j - b.v) * second_slope;
    if (x1 < x0) std::swap(x0, x1);
    if (!(x1 > 0.0) || !(x0 <= width - 1)) continue;
    const int i0 = static_cast<int>(std::ceil(std::max(x0, 0.0)));
    const int i1 = static_cast<int>(std::ceil(std::min(x1, static_cast<double>(width))));
    if (i0 < i1) span(j, i0, i1);
  }
}

struct GroundRaster {
  const Ground& ground;
  const View& view;
  Plane& inverse_depth;
  Eigen::Vector3d start, per_column, per_row;

  // 1/depth of the plane through height h at (x, y) with slopes sx, sy is linear in the pixel.
  void triangle(Corner a, Corner b, Corner c, double x, double y, double h, double sx, double sy) const {
    const double below = h + sx * (view.center.x() - x) + sy * (view.center.y() - y) - view.center.z();
    if (below > -1e-9) return;  // seen from beneath
    const double inverse = 1.0 / below;
    const double at_start = (start.z() - sx * start.x() - sy * start.y()) * inverse;
    const double along_u = (per_column.z() - sx * per_column.x() - sy * per_column.y()) * inverse;
    const double along_v = (per_row.z() - sx * per_row.x() - sy * per_row.y()) * inverse;
    const auto step = static_cast<float>(along_u);
    scan_triangle(a, b, c, view.width, view.height, [&](int j, int i0, int i1) {
      const auto first = static_cast<float>(at_start + j * along_v + i0 * along_u);
      float* w = inverse_depth.row(j) + i0;
      const int n = i1 - i0;
      for (int i = 0; i < n; ++i) {
        const float value = first + static_cast<float>(i) * step;
        w[i] = w[i] < value ? value : w[i];
      }
    });
  }
};

// Range of columns of a vertex row (at world y) that the view can see: the wedge between its outermost rays.
struct Wedge {
  Eigen::Vector2d apex, left_normal, right_normal;
  bool all = false;

  explicit Wedge(const View& view) {
    Eigen::Vector2d forward = view.R_world_camera.col(2).head<2>();
    const double length = forward.norm();
    apex = view.center.head<2>();
    double widest = 0.0;
    if (length > 0.2) {
      forward /= length;
      for (int k = 0; k < 4; ++k) {
        const Eigen::Vector3d r = view.ray_start() + view.ray_per_column() * ((k & 1) * view.width) +
                                  view.ray_per_row() * ((k >> 1) * view.height);
        const double along = r.head<2>().dot(forward);
        const double across = std::abs(forward.x() * r.y() - forward.y() * r.x());
        if (along <= 0.2 * across) all = true;
        if (!all) widest = std::max(widest, across / along);
      }
    } else {
      all = true;
    }
    if (all) return;
    apex -= forward * 2.5;  // what is under the camera, too
    const Eigen::Vector2d left(-forward.y(), forward.x());
    left_normal = (widest * forward - left).normalized();
    right_normal = (widest * forward + left).normalized();
  }
  bool columns(double y, double& x0, double& x1) const {
    x0 = apex.x() - kViewRangeM;
    x1 = apex.x() + kViewRangeM;
    if (all) return true;
    constexpr double kSlack = -1.6 * Ground::kCellM;
    for (const Eigen::Vector2d& n : {left_normal, right_normal}) {
      const double rest = kSlack - n.y() * (y - apex.y());  // n.x (x - apex.x) >= rest
      if (n.x() > 1e-9) x0 = std::max(x0, apex.x() + rest / n.x());
      if (n.x() < -1e-9) x1 = std::min(x1, apex.x() + rest / n.x());
    }
    return x0 <= x1;
  }
};

// Cuts the triangle at the near plane; the plane equation of the surface stays.
int clip_near(const Eigen::Vector3d (&in)[3], Eigen::Vector3d (&out)[4]) {
  int n = 0;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d& p = in[k];
    const Eigen::Vector3d& q = in[(k + 1) % 3];
    const bool p_in = p.z() >= kNearM;
    const bool q_in = q.z() >= kNearM;
    if (p_in) out[n++] = p;
    if (p_in != q_in) out[n++] = p + (kNearM - p.z()) / (q.z() - p.z()) * (q - p);
  }
  return n;
}

}  // namespace

void Plane::resize(int width, int height) {
  stride_ = (width + 2 * kBorder + 15) / 16 * 16;
  height_ = height;
  data_.assign(static_cast<std::size_t>(stride_ * (height + 2)), 0.0F);
}

void Plane::fill(float value) { std::fill(row(0) - kBorder, row(height_) - kBorder, value); }

void raster_ground(const Ground& g, const View& view, Plane& inverse_depth, RasterScratch& scratch) {
  constexpr double cell = Ground::kCellM;
  const GroundRaster raster{g, view, inverse_depth, view.ray_start(), view.ray_per_column(), view.ray_per_row()};
  const Wedge wedge(view);
  const Eigen::Matrix3d R = view.R_world_camera.transpose();
  const int j0 = std::max(static_cast<int>(std::floor((view.center.y() - kViewRangeM) / cell) - g.first_j), 0);
  const int j1 = std::min(static_cast<int>(std::ceil((view.center.y() + kViewRangeM) / cell) - g.first_j), g.rows - 1);
  for (int k = 0; k < 2; ++k) {
    scratch.u[k].resize(static_cast<std::size_t>(g.columns));
    scratch.v[k].resize(static_cast<std::size_t>(g.columns));
    scratch.depth[k].resize(static_cast<std::size_t>(g.columns));
  }
  const auto to_camera = [&](int i, int j) -> Eigen::Vector3d {
    return R * (Eigen::Vector3d((i + g.first_i) * cell, (j + g.first_j) * cell, g.at(i, j)) - view.center);
  };
  int last_first = 0;
  int last_end = 0;
  for (int j = j0; j <= j1; ++j) {
    double x0 = 0.0;
    double x1 = 0.0;
    int first = 0;
    int end = 0;
    if (wedge.columns((j + g.first_j) * cell, x0, x1)) {
      first = std::max(static_cast<int>(std::floor(x0 / cell) - g.first_i), 0);
      end = std::min(static_cast<int>(std::ceil(x1 / cell) - g.first_i) + 1, g.columns);
    }
    double* u = scratch.u[j & 1].data();
    double* v = scratch.v[j & 1].data();
    double* depth = scratch.depth[j & 1].data();
    const double y = (j + g.first_j) * cell - view.center.y();
    for (int i = first; i < end; ++i) {
      const double x = (i + g.first_i) * cell - view.center.x();
      const double h = g.at(i, j) - view.center.z();
      const double z = R(2, 0) * x + R(2, 1) * y + R(2, 2) * h;
      const double scale = view.focal_px / z;
      depth[i] = z;
      u[i] = (R(0, 0) * x + R(0, 1) * y + R(0, 2) * h) * scale + view.cx_px - view.offset_x;
      v[i] = (R(1, 0) * x + R(1, 1) * y + R(1, 2) * h) * scale + view.cy_px - view.offset_y;
    }
    if (j > j0) {
      const double* ub = scratch.u[(j - 1) & 1].data();
      const double* vb = scratch.v[(j - 1) & 1].data();
      const double* db = scratch.depth[(j - 1) & 1].data();
      const int from = std::max(first, last_first);
      const int to = std::min(end, last_end) - 1;
      for (int i = from; i < to; ++i) {
        // Corners 00 (lower left), 10, 01, 11.
        const double h00 = g.at(i, j - 1);
        const double h10 = g.at(i + 1, j - 1);
        const double h01 = g.at(i, j);
        const double h11 = g.at(i + 1, j);
        const double px = (i + g.first_i) * cell;
        const double py = (j - 1 + g.first_j) * cell;
        const bool whole = db[i] >= kNearM && db[i + 1] >= kNearM && depth[i] >= kNearM && depth[i + 1] >= kNearM;
        if (whole) {
          const double v_low = std::min(std::min(vb[i], vb[i + 1]), std::min(v[i], v[i + 1]));
          const double v_high = std::max(std::max(vb[i], vb[i + 1]), std::max(v[i], v[i + 1]));
          if (v_high < 0.0 || v_low > view.height - 1 || std::ceil(v_low) > v_high) continue;
          const Corner c00{ub[i], vb[i]};
          const Corner c10{ub[i + 1], vb[i + 1]};
          const Corner c01{u[i], v[i]};
          const Corner c11{u[i + 1], v[i + 1]};
          raster.triangle(c00, c10, c11, px, py, h00, (h10 - h00) / cell, (h11 - h10) / cell);
          raster.triangle(c00, c11, c01, px, py, h00, (h11 - h01) / cell, (h01 - h00) / cell);
          continue;
        }
        if (db[i] < kNearM && db[i + 1] < kNearM && depth[i] < kNearM && depth[i + 1] < kNearM) continue;
        const Eigen::Vector3d corner[4] = {to_camera(i, j - 1), to_camera(i + 1, j - 1), to_camera(i, j),
                                           to_camera(i + 1, j)};
        for (int t = 0; t < 2; ++t) {
          Eigen::Vector3d clipped[4];
          const int n = clip_near({corner[0], corner[t == 0 ? 1 : 3], corner[t == 0 ? 3 : 2]}, clipped);
          Corner p[4];
          for (int k = 0; k < n; ++k) {
            p[k] = {clipped[k].x() / clipped[k].z() * view.focal_px + view.cx_px - view.offset_x,
                    clipped[k].y() / clipped[k].z() * view.focal_px + view.cy_px - view.offset_y};
          }
          const double sx = t == 0 ? (h10 - h00) / cell : (h11 - h01) / cell;
          const double sy = t == 0 ? (h11 - h10) / cell : (h01 - h00) / cell;
          for (int k = 2; k < n; ++k) raster.triangle(p[0], p[k - 1], p[k], px, py, h00, sx, sy);
        }
      }
    }
    last_first = first;
    last_end = end;
  }
}

}  // namespace cliquevo::drivers::sim
