// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/world.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/simulator/gradient_noise.h"
#include "drivers/simulator/hash.h"

namespace cliquevo::drivers::sim {

namespace {

constexpr double kMarginM = kViewRangeM + 4.0;

struct Bounds {
  Eigen::Vector2d low, high;
};

Bounds course_bounds(const Course& course) {
  Bounds b{course.position(0.0), course.position(0.0)};
  const double length = std::min(course.length_m(), course.lap_m());
  const int steps = static_cast<int>(length / 0.5) + 1;
  for (int k = 0; k <= steps; ++k) {
    const Eigen::Vector2d p = course.position(0.5 * k);
    b.low = b.low.cwiseMin(p);
    b.high = b.high.cwiseMax(p);
  }
  return b;
}

// Distance from the whole course (not only from the part that is driven: the world must not depend on that).
class CourseDistance {
 public:
  static constexpr double kReachM = 32.0;
  static constexpr double kBinM = 4.0;
  CourseDistance(const Course& course, const Bounds& b)
      : low_(b.low.array() - kMarginM),
        columns_(static_cast<int>((b.high.x() - b.low.x() + 2 * kMarginM) / kBinM) + 1),
        rows_(static_cast<int>((b.high.y() - b.low.y() + 2 * kMarginM) / kBinM) + 1),
        bins_(static_cast<std::size_t>(columns_) * rows_) {
    double from = 0.0;
    double to = course.lap_m();
    if (!std::isfinite(to)) {  // straight: from well behind the start to what is seen at its end
      from = -kMarginM;
      to = course.length_m() + kMarginM;
    }
    const int steps = static_cast<int>(std::ceil((to - from) / 0.25));
    for (int k = 0; k < steps; ++k) {
      const Eigen::Vector2d p = course.position(from + 0.25 * k);
      const auto x = static_cast<int>(std::floor((p.x() - low_.x()) / kBinM));
      const auto y = static_cast<int>(std::floor((p.y() - low_.y()) / kBinM));
      if (x >= 0 && y >= 0 && x < columns_ && y < rows_) bins_[static_cast<std::size_t>(y) * columns_ + x].push_back(p);
    }
  }
  double operator()(double x, double y, double reach) const {
    double best = reach * reach;
    const auto x0 = static_cast<int>(std::floor((x - reach - low_.x()) / kBinM));
    const auto x1 = static_cast<int>(std::floor((x + reach - low_.x()) / kBinM));
    const auto y0 = static_cast<int>(std::floor((y - reach - low_.y()) / kBinM));
    const auto y1 = static_cast<int>(std::floor((y + reach - low_.y()) / kBinM));
    for (int j = std::max(y0, 0); j <= std::min(y1, rows_ - 1); ++j) {
      for (int i = std::max(x0, 0); i <= std::min(x1, columns_ - 1); ++i) {
        for (const Eigen::Vector2d& p : bins_[static_cast<std::size_t>(j) * columns_ + i])
          best = std::min(best, (p - Eigen::Vector2d(x, y)).squaredNorm());
      }
    }
    return std::sqrt(best);
  }

 private:
  Eigen::Vector2d low_;
  int columns_, rows_;
  std::vector<std::vector<Eigen::Vector2d>> bins_;
};

// Random numbers are drawn one a statement: in what order the parts of an expression are evaluated, a compiler chooses.
// Where that order is not the one of the axes, it is the one in which the worlds were made first.
Eigen::Vector3d any_texture_offset(Random& random) {
  Eigen::Vector3d offset;
  for (int axis = 0; axis < 3; ++axis) offset[axis] = random.uniform(0.0, 64.0);
  return offset;
}

std::uint32_t byte(double v) { return static_cast<std::uint32_t>(std::clamp(v + 0.5, 0.0, 255.0)); }

std::vector<std::uint32_t> quads(const std::vector<double>& v, int columns, int rows) {
  std::vector<std::uint32_t> out(v.size());
  for (int j = 0; j < rows; ++j) {
    for (int i = 0; i < columns; ++i) {
      const int ir = std::min(i + 1, columns - 1);
      const int jb = std::min(j + 1, rows - 1);
      const auto at = [&](int x, int y) { return byte(v[static_cast<std::size_t>(y) * columns + x]); };
      out[static_cast<std::size_t>(j) * columns + i] = at(i, j) | at(ir, j) << 8 | at(i, jb) << 16 | at(ir, jb) << 24;
    }
  }
  return out;
}

}  // namespace

World::World(const SimulatorOptions& options, const Course& course) : options_(options), course_(course) {
  make_ground();
  make_solids();
}

void World::make_ground() {
  const Bounds b = course_bounds(course_);
  constexpr double cell = Ground::kCellM;
  Ground& g = ground_;
  g.first_i = static_cast<int>(std::floor((b.low.x() - kMarginM) / cell));
  g.first_j = static_cast<int>(std::floor((b.low.y() - kMarginM) / cell));
  g.columns = static_cast<int>(std::ceil((b.high.x() + kMarginM) / cell) - g.first_i) + 1;
  g.rows = static_cast<int>(std::ceil((b.high.y() + kMarginM) / cell) - g.first_j) + 1;
  const std::size_t count = static_cast<std::size_t>(g.columns) * g.rows;
  g.height.resize(count);
  for (int j = 0; j < g.rows; ++j) {
    for (int i = 0; i < g.columns; ++i) {
      g.height[static_cast<std::size_t>(j) * g.columns + i] =
          static_cast<float>(course_.terrain().height((i + g.first_i) * cell, (j + g.first_j) * cell));
    }
  }

  std::vector<double> brightness(count);
  std::vector<double> grass(count);
  const std::uint64_t seed = mix64(options_.world_seed ^ 0x6772617373ULL);
  for (int j = 0; j < g.rows; ++j) {
    for (int i = 0; i < g.columns; ++i) {
      const double x = (i + g.first_i) * cell;
      const double y = (j + g.first_j) * cell;
      const int il = std::max(i - 1, 0);
      const int ir = std::min(i + 1, g.columns - 1);
      const int jl = std::max(j - 1, 0);
      const int jr = std::min(j + 1, g.rows - 1);
      const double sx = (g.at(ir, j) - g.at(il, j)) / ((ir - il) * cell);
      const double sy = (g.at(i, jr) - g.at(i, jl)) / ((jr - jl) * cell);
      const double cosine = (kSunZ - sx * kSunX - sy * kSunY) / std::sqrt(1.0 + sx * sx + sy * sy);
      const double light = kAmbient + kDiffuse * std::max(cosine, 0.0);
      const double patch = gradient_noise(seed, x / 9.0, y / 9.0) + 0.6 * gradient_noise(seed + 1, x / 3.7, y / 3.7);
      const double mix =
          std::clamp(0.5 + 1.6 * patch, 0.12, 0.88);  // never one texture alone: their sum repeats nowhere
      const double tone = gradient_noise(seed + 2, x / 17.0, y / 17.0) +
                          0.7 * gradient_noise(seed + 3, x / 5.1, y / 5.1) +
                          0.5 * gradient_noise(seed + 4, x / 2.3, y / 2.3);
      const std::size_t at = static_cast<std::size_t>(j) * g.columns + i;
      brightness[at] = light * (mix * 96.0 + (1.0 - mix) * 122.0) * (1.0 + 0.35 * tone);
      grass[at] = 255.0 * mix;
    }
  }
  g.brightness = quads(brightness, g.columns, g.rows);
  g.grassiness = quads(grass, g.columns, g.rows);
}

void World::add_rock(double x, double y, double radius, std::uint64_t seed) {
  Random random(seed);
  Solid s;
  const double flat = random.uniform(0.45, 0.9);
  const double wide = random.uniform(0.7, 1.0);
  const double length = random.uniform(0.85, 1.25);
  const Eigen::Vector3d axes(radius * length, radius * wide, radius * flat);
  const double tilt = random.uniform(-0.35, 0.35);
  const double yaw = random.uniform(0.0, 2.0 * std::numbers::pi);
  s.R_world_local =
      (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(tilt, Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  s.ground_m = course_.terrain().height(x, y);
  s.center = {x, y, s.ground_m + axes.z() * random.uniform(0.0, 0.55)};
  s.curvature = axes.cwiseProduct(axes).cwiseInverse();
  s.half_size = axes;
  if (radius > 0.035) {  // broken faces
    s.planes = 5 + static_cast<int>(random.uniform(0.0, 3.0));
    for (int k = 0; k < s.planes; ++k) {
      Eigen::Vector3d n;
      n.z() = random.uniform(-0.3, 1.0);
      n.y() = random.uniform(-1.0, 1.0);
      n.x() = random.uniform(-1.0, 1.0);
      n.normalize();
      s.normal[k] = n;
      s.distance[k] = random.uniform(0.62, 0.93) * n.cwiseProduct(axes).norm();
    }
  }
  s.albedo = static_cast<float>(random.uniform(75.0, 165.0));
  s.contrast = static_cast<float>(random.uniform(0.20, 0.38));
  s.texel_m = std::clamp(radius / 20.0, 0.002, 0.012);
  s.texture_offset = any_texture_offset(random);
  s.foot_radius_m = radius * 1.05;
  s.top_m = s.center.z() - s.ground_m + axes.z();
  solids_.push_back(s);
}

void World::add_post(double x, double y, std::uint64_t seed) {
  Random random(seed);
  Solid s;
  const double radius = random.uniform(0.035, 0.11);
  const double height = random.uniform(0.5, 1.9);
  s.ground_m = course_.terrain().height(x, y);
  const double lean = random.uniform(0.0, 0.12);
  const double yaw = random.uniform(0.0, 2.0 * std::numbers::pi);
  s.R_world_local =
      (Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(lean, Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  s.center = {x, y, s.ground_m + 0.5 * height - 0.1};
  s.half_size = {radius, radius, 0.5 * height + 0.1};
  s.planes = 2;
  s.normal[0] = {0.0, 0.0, 1.0};
  s.normal[1] = {0.0, 0.0, -1.0};
  s.distance[0] = s.distance[1] = s.half_size.z();
  s.curvature = {1.0 / (radius * radius), 1.0 / (radius * radius), 0.0};
  s.albedo = static_cast<float>(random.uniform(70.0, 150.0));
  s.contrast = 0.35F;
  s.texel_m = 0.005;
  s.texture_offset = any_texture_offset(random);
  s.foot_radius_m = radius;
  s.top_m = height;
  solids_.push_back(s);
}

void World::make_solids() {
  const Bounds b = course_bounds(course_);
  const CourseDistance distance(course_, b);
  const double amount = options_.rocks < 0 ? 1.0 : options_.rocks / 100.0;
  constexpr double cell = 2.0;
  const std::uint64_t seed = mix64(options_.world_seed ^ 0x726f636bULL);
  // What stands there, a cell of 2 m by 2 m at a time: numbers a square metre, radius, clearance from the course.
  struct Kind {
    double density, least_m, most_m, clearance_m, reach_m;
  };
  static constexpr Kind kKinds[] = {{1.1, 0.012, 0.045, 0.0, 7.0},    // pebbles
                                    {0.16, 0.045, 0.13, 0.55, 14.0},  // stones
                                    {0.022, 0.13, 0.50, 1.2, 32.0},   // rocks
                                    {0.010, 0.0, 0.0, 1.6, 28.0}};    // posts
  const auto i0 = static_cast<int>(std::floor((b.low.x() - kMarginM) / cell));
  const auto i1 = static_cast<int>(std::ceil((b.high.x() + kMarginM) / cell));
  const auto j0 = static_cast<int>(std::floor((b.low.y() - kMarginM) / cell));
  const auto j1 = static_cast<int>(std::ceil((b.high.y() + kMarginM) / cell));
  for (int j = j0; j < j1; ++j) {
    for (int i = i0; i < i1; ++i) {
      const double from_center = distance((i + 0.5) * cell, (j + 0.5) * cell, CourseDistance::kReachM);
      if (from_center >= CourseDistance::kReachM) continue;
      for (int k = 0; k < 4; ++k) {
        const Kind& kind = kKinds[k];
        if (from_center > kind.reach_m) continue;
        Random random(hash_cell(seed + static_cast<std::uint64_t>(k), i, j));
        const double expected = amount * kind.density * cell * cell;
        auto count = static_cast<int>(expected);
        if (random.uniform() < expected - count) ++count;
        for (int n = 0; n < count; ++n) {
          const double x = (i + random.uniform()) * cell;
          const double y = (j + random.uniform()) * cell;
          // Power law: many small ones, few large ones.
          const double u = random.uniform();
          const double radius =
              kind.least_m > 0.0
                  ? 1.0 / std::sqrt((1.0 - u) / (kind.least_m * kind.least_m) + u / (kind.most_m * kind.most_m))
                  : 0.0;
          const std::uint64_t own = random.bits();
          if (kind.clearance_m > 0.0 && distance(x, y, 2.5) < kind.clearance_m + radius) continue;
          if (k == 3) {
            add_post(x, y, own);
          } else {
            add_rock(x, y, radius, own);
          }
        }
      }
    }
  }
  const auto natural = static_cast<std::ptrdiff_t>(solids_.size());
  if (options_.railings) make_railing();
  if (options_.walls || options_.glass) make_walls();
  // They are made along the whole way: what no camera of this run can see goes.
  const auto unseen = [&](const Solid& s) {
    const Eigen::Array2d at = s.center.head<2>();
    return (at < b.low.array() - kMarginM).any() || (at > b.high.array() + kMarginM).any();
  };
  solids_.erase(std::remove_if(solids_.begin() + natural, solids_.end(), unseen), solids_.end());
  bin_solids(b.low, b.high);
}

void World::bin_solids(const Eigen::Vector2d& low, const Eigen::Vector2d& high) {
  bin_first_x_ = static_cast<int>(std::floor((low.x() - kMarginM) / kBinM)) - 1;
  bin_first_y_ = static_cast<int>(std::floor((low.y() - kMarginM) / kBinM)) - 1;
  bin_columns_ = static_cast<int>(std::ceil((high.x() + kMarginM) / kBinM) - bin_first_x_) + 2;
  bin_rows_ = static_cast<int>(std::ceil((high.y() + kMarginM) / kBinM) - bin_first_y_) + 2;
  bins_.resize(static_cast<std::size_t>(bin_columns_) * bin_rows_);
  for (std::size_t n = 0; n < solids_.size(); ++n) {
    const auto x = static_cast<int>(std::floor(solids_[n].center.x() / kBinM)) - bin_first_x_;
    const auto y = static_cast<int>(std::floor(solids_[n].center.y() / kBinM)) - bin_first_y_;
    bins_[static_cast<std::size_t>(y) * bin_columns_ + x].push_back(static_cast<int>(n));
  }
}

void World::near(double x, double y, double range_m, std::vector<int>& indices) const {
  indices.clear();
  const auto low = [&](double v, int first) {
    return std::max<int>(static_cast<int>(std::floor((v - range_m) / kBinM)) - first, 0);
  };
  const auto high = [&](double v, int first, int count) {
    return std::min<int>(static_cast<int>(std::floor((v + range_m) / kBinM)) - first, count - 1);
  };
  for (int j = low(y, bin_first_y_); j <= high(y, bin_first_y_, bin_rows_); ++j) {
    for (int i = low(x, bin_first_x_); i <= high(x, bin_first_x_, bin_columns_); ++i)
      for (const int n : bins_[static_cast<std::size_t>(j) * bin_columns_ + i]) indices.push_back(n);
  }
}

Solid World::box(const Eigen::Vector2d& place, double yaw, const Eigen::Vector3d& half_size) const {
  Solid b;
  b.half_size = half_size;
  b.R_world_local = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  b.ground_m = course_.terrain().height(place.x(), place.y());
  b.center = {place.x(), place.y(), b.ground_m + half_size.z() + 0.03};
  b.planes = 6;
  for (int k = 0; k < 6; ++k) {
    b.normal[static_cast<std::size_t>(k)] = (k % 2 == 0 ? 1.0 : -1.0) * Eigen::Vector3d::Unit(k / 2);
    b.distance[static_cast<std::size_t>(k)] = half_size[k / 2];
  }
  b.foot_radius_m = 0.8 * std::max(half_size.x(), half_size.y());
  b.top_m = 2.0 * half_size.z();
  return b;
}

// Just ahead, swaying and keeping no constant distance: most of the view moves otherwise than the world.
Solid World::lorry(double frame) const {
  const double s = (course_.moves() ? options_.step_m * frame : 0.0) + 3.9 + 0.4 * std::sin(0.05 * frame);
  const double psi = course_.heading(s);
  const double side = 0.35 * std::sin(0.037 * frame);
  const Eigen::Vector2d place = course_.position(s) + side * Eigen::Vector2d(-std::sin(psi), std::cos(psi));
  Solid b = box(place, psi + 0.1 * std::sin(0.043 * frame), {0.9, 1.5, 0.9});
  b.albedo = 210.0F;
  b.contrast = 0.4F;
  b.texel_m = 0.012;
  return b;
}

std::vector<Solid> World::movers(double frame) const {
  std::vector<Solid> out;
  if (options_.scene == "lorry") out.push_back(lorry(frame));
  for (int m = 0; m < options_.movers; ++m) {
    Random random(hash_cell(mix64(options_.world_seed ^ 0x6d6f766572ULL), m, 0));
    // Ahead of the camera, crossing and coming back: a box of the size of a barrow or a small car.
    const double ahead = random.uniform(3.5, 8.0);
    const double sway = random.uniform(1.0, 3.0);
    const double rate = random.uniform(0.02, 0.05);
    const double phase = random.uniform(0.0, 2.0 * std::numbers::pi);
    const double s =
        (course_.moves() ? options_.step_m * frame : 0.0) + ahead + 1.0 * std::sin(0.6 * rate * frame + 2.0 * phase);
    const Eigen::Vector2d p = course_.position(s);
    const double psi = course_.heading(s);
    const double aside = random.uniform(-1.0, 1.0);
    const double side = sway * std::sin(rate * frame + phase) + aside;
    const Eigen::Vector2d q = p + side * Eigen::Vector2d(-std::sin(psi), std::cos(psi));
    Eigen::Vector3d half_size;
    half_size.z() = random.uniform(0.2, 0.5);
    half_size.y() = random.uniform(0.2, 0.4);
    half_size.x() = random.uniform(0.25, 0.6);
    Solid b = box(q, psi + 0.8 * std::cos(rate * frame + phase), half_size);
    b.albedo = static_cast<float>(random.uniform(90.0, 150.0));
    b.contrast = 0.5F;
    b.texel_m = 0.012;
    b.texture_offset = any_texture_offset(random);
    out.push_back(b);
  }
  return out;
}

}  // namespace cliquevo::drivers::sim
