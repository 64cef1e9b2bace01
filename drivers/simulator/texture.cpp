// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/texture.h"

#include <algorithm>
#include <cmath>
#include <future>
#include <numbers>
#include <tuple>
#include <utility>

#include "drivers/simulator/gradient_noise.h"
#include "drivers/simulator/hash.h"

namespace cliquevo::drivers::sim {

namespace {

constexpr int kMask = Tile::kSize - 1;

using Canvas = LargeArray<float>;

// Periodic noise: octaves of a random lattice, interpolated bicubically (B-spline), coarse to fine.
void add_noise(Canvas& canvas, int size, int cell, float amplitude, std::uint64_t seed) {
  const int n = size / cell;
  Random random(seed);
  std::vector<float> lattice(static_cast<std::size_t>(n) * n);
  for (float& v : lattice) v = static_cast<float>(random.uniform(-1.0, 1.0)) * amplitude;
  std::vector<float> weight(static_cast<std::size_t>(cell) * 4);
  for (int i = 0; i < cell; ++i) {
    const float t = static_cast<float>(i) / static_cast<float>(cell);
    float* w = &weight[static_cast<std::size_t>(i) * 4];
    w[0] = (1 - t) * (1 - t) * (1 - t) / 6;
    w[1] = (3 * t * t * t - 6 * t * t + 4) / 6;
    w[2] = (-3 * t * t * t + 3 * t * t + 3 * t + 1) / 6;
    w[3] = t * t * t / 6;
  }
  std::vector<float> line(static_cast<std::size_t>(n));
  for (int y = 0; y < size; ++y) {
    const float* wy = &weight[static_cast<std::size_t>(y % cell) * 4];
    for (int x = 0; x < n; ++x) {
      float sum = 0;
      for (int k = 0; k < 4; ++k) sum += wy[k] * lattice[static_cast<std::size_t>((y / cell + k) % n) * n + x];
      line[static_cast<std::size_t>(x)] = sum;
    }
    float* out = &canvas[static_cast<std::size_t>(y) * size];
    for (int cx = 0; cx < n; ++cx) {
      const float l[4] = {line[static_cast<std::size_t>(cx)], line[static_cast<std::size_t>((cx + 1) % n)],
                          line[static_cast<std::size_t>((cx + 2) % n)], line[static_cast<std::size_t>((cx + 3) % n)]};
      for (int i = 0; i < cell; ++i) {
        const float* w = &weight[static_cast<std::size_t>(i) * 4];
        out[cx * cell + i] += w[0] * l[0] + w[1] * l[1] + w[2] * l[2] + w[3] * l[3];
      }
    }
  }
}

struct Leaf {
  double x, y;
  double half_length, half_width;  // texels
  int direction;                   // of kDirections in half a turn
  float albedo;
  float slope;  // brightness from one side to the other: stones are lit from one side
};

constexpr int kDirections = 256;

struct Direction {
  float c, s;
};

const std::vector<Direction>& directions() {
  static const std::vector<Direction> kTable = [] {
    std::vector<Direction> t;
    for (int i = 0; i < kDirections; ++i) {
      const double angle = std::numbers::pi * i / kDirections;
      t.push_back({static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))});
    }
    return t;
  }();
  return kTable;
}

void paint(Canvas& canvas, const Leaf& leaf) {
  const auto [c, s] = directions()[static_cast<std::size_t>(leaf.direction)];
  const auto il = static_cast<float>(1.0 / leaf.half_length);
  const auto iw = static_cast<float>(1.0 / leaf.half_width);
  const double l2 = leaf.half_length * leaf.half_length;
  const double w2 = leaf.half_width * leaf.half_width;
  const double reach_x = std::sqrt(l2 * c * c + w2 * s * s);
  const double reach_y = std::sqrt(l2 * s * s + w2 * c * c);
  const int x0 = static_cast<int>(std::ceil(leaf.x - reach_x));
  const int x1 = static_cast<int>(std::floor(leaf.x + reach_x));
  const int y1 = static_cast<int>(std::floor(leaf.y + reach_y));
  for (int y = static_cast<int>(std::ceil(leaf.y - reach_y)); y <= y1; ++y) {
    float* row = &canvas[static_cast<std::size_t>(y & kMask) * Tile::kSize];
    const auto dy = static_cast<float>(y - leaf.y);
    for (int x = x0; x <= x1; ++x) {
      const auto dx = static_cast<float>(x - leaf.x);
      const float a = (c * dx + s * dy) * il;
      const float b = (c * dy - s * dx) * iw;
      const float r2 = a * a + b * b;
      if (r2 > 1.0F) continue;
      // Light from one fixed side of the tile, darker towards the rim: a rounded thing lying on the ground.
      row[x & kMask] = leaf.albedo + leaf.slope * ((0.8F * dx + 0.6F * dy) * iw * 0.6F - 0.5F * r2 * r2);
    }
  }
}

// 1-2-1 in both directions, periodic: takes off what the texel grid cannot hold.
void smooth(Canvas& canvas, int size) {
  Canvas line(static_cast<std::size_t>(size));
  const int mask = size - 1;
  for (int y = 0; y < size; ++y) {
    float* r = &canvas[static_cast<std::size_t>(y) * size];
    for (int x = 0; x < size; ++x)
      line[static_cast<std::size_t>(x)] = 0.25F * (r[(x - 1) & mask] + r[(x + 1) & mask]) + 0.5F * r[x];
    std::copy(line.begin(), line.end(), r);
  }
  Canvas source = canvas;
  for (int y = 0; y < size; ++y) {
    const float* a = &source[static_cast<std::size_t>((y - 1) & mask) * size];
    const float* b = &source[static_cast<std::size_t>(y) * size];
    const float* c = &source[static_cast<std::size_t>((y + 1) & mask) * size];
    float* out = &canvas[static_cast<std::size_t>(y) * size];
    for (int x = 0; x < size; ++x) out[x] = 0.25F * (a[x] + c[x]) + 0.5F * b[x];
  }
}

void normalise(Canvas& canvas, float mean, float deviation) {
  double sum = 0.0;
  double squares = 0.0;
  for (const float v : canvas) {
    sum += v;
    squares += static_cast<double>(v) * v;
  }
  const double m = sum / static_cast<double>(canvas.size());
  const double sd = std::sqrt(squares / static_cast<double>(canvas.size()) - m * m);
  const auto gain = static_cast<float>(deviation / sd);
  for (float& v : canvas) v = std::clamp(mean + (v - static_cast<float>(m)) * gain, 0.0F, 255.0F);
}

std::uint32_t byte(float v) { return static_cast<std::uint32_t>(std::clamp(v + 0.5F, 0.0F, 255.0F)); }

std::uint32_t quad(std::uint32_t a, std::uint32_t b, std::uint32_t c, std::uint32_t d) {
  return a | b << 8 | c << 16 | d << 24;
}

void append_quads(LargeArray<std::uint32_t>& quads, const Canvas& canvas, int size) {
  const int mask = size - 1;
  for (int y = 0; y < size; ++y) {
    const float* a = &canvas[static_cast<std::size_t>(y) * size];
    const float* b = &canvas[static_cast<std::size_t>((y + 1) & mask) * size];
    for (int x = 0; x < size; ++x) {
      const int xr = (x + 1) & mask;
      quads.push_back(quad(byte(a[x]), byte(a[xr]), byte(b[x]), byte(b[xr])));
    }
  }
}

Tile make_tile(Canvas canvas) {
  Tile tile;
  tile.pairs.resize(Tile::start(Tile::kLastLevel + 1));
  int size = Tile::kSize;
  for (int level = 0;; ++level) {
    std::vector<std::uint8_t> bytes(canvas.size());
    std::transform(canvas.begin(), canvas.end(), bytes.begin(),
                   [](float v) { return static_cast<std::uint8_t>(byte(v)); });
    const int mask = size - 1;
    for (int y = 0; y < size; ++y) {
      const std::uint8_t* a = &bytes[static_cast<std::size_t>(y) * size];
      const std::uint8_t* b = &bytes[static_cast<std::size_t>((y + 1) & mask) * size];
      std::uint16_t* out = &tile.pairs[Tile::start(level) + static_cast<std::size_t>(y) * (size + Tile::kPadding)];
      for (int x = 0; x < size + Tile::kPadding; ++x)
        out[x] = static_cast<std::uint16_t>(a[x & mask] | b[x & mask] << 8);
    }
    if (level == Tile::kLastLevel) break;
    const int half = size / 2;
    Canvas next(static_cast<std::size_t>(half) * half);
    for (int y = 0; y < half; ++y) {
      const float* a = &canvas[static_cast<std::size_t>(2 * y) * size];
      const float* b = a + size;
      for (int x = 0; x < half; ++x)
        next[static_cast<std::size_t>(y) * half + x] = 0.25F * (a[2 * x] + a[2 * x + 1] + b[2 * x] + b[2 * x + 1]);
    }
    canvas = std::move(next);
    size = half;
  }
  return tile;
}

// Soil and gravel: stones of 1.5 to 60 texels on a fractal ground.
Tile make_gravel() {
  Canvas canvas(static_cast<std::size_t>(Tile::kSize) * Tile::kSize, 0.0F);
  for (int cell = 512; cell >= 2; cell /= 2)
    add_noise(canvas, Tile::kSize, cell, 0.55F * std::pow(static_cast<float>(cell) / 512.0F, 0.25F), 100 + cell);
  Random random(0x67a7e1);
  const double area = static_cast<double>(Tile::kSize) * Tile::kSize;
  for (int layer = 0; layer < 2; ++layer) {
    for (int size = 0; size < 11; ++size) {  // down by a factor of sqrt(2) each
      const double radius = 48.0 * std::pow(2.0, -0.5 * size);
      const auto count = static_cast<int>(0.10 * area / (std::numbers::pi * radius * radius));
      for (int i = 0; i < count; ++i) {
        Leaf leaf{};
        leaf.x = random.uniform(0.0, Tile::kSize);
        leaf.y = random.uniform(0.0, Tile::kSize);
        leaf.half_length = radius * random.uniform(0.8, 1.3);
        leaf.half_width = leaf.half_length * random.uniform(0.5, 0.95);
        leaf.direction = static_cast<int>(random.uniform(0.0, kDirections));
        leaf.albedo = static_cast<float>(random.uniform(-1.0, 1.0)) * (radius > 16.0 ? 0.6F : 1.1F);
        leaf.slope = static_cast<float>(random.uniform(0.1, 0.7));
        paint(canvas, leaf);
      }
    }
  }
  for (int cell = 8; cell >= 2; cell /= 2) add_noise(canvas, Tile::kSize, cell, 0.25F, 200 + cell);
  smooth(canvas, Tile::kSize);
  normalise(canvas, 128.0F, 42.0F);
  return make_tile(std::move(canvas));
}

// Grass and straw: blades that lie in all directions, in tufts.
Tile make_grass() {
  Canvas canvas(static_cast<std::size_t>(Tile::kSize) * Tile::kSize, 0.0F);
  for (int cell = 512; cell >= 4; cell /= 2)
    add_noise(canvas, Tile::kSize, cell, 0.5F * std::pow(static_cast<float>(cell) / 512.0F, 0.2F), 300 + cell);
  const Canvas ground = canvas;
  Random random(0x96a55);
  const double area = static_cast<double>(Tile::kSize) * Tile::kSize;
  for (int size = 0; size < 7; ++size) {
    const double length = 40.0 * std::pow(2.0, -0.5 * size);
    const double width = std::max(1.0, length / 14.0);
    const auto count = static_cast<int>(0.22 * area / (std::numbers::pi * length * width));
    for (int i = 0; i < count; ++i) {
      Leaf leaf{};
      leaf.x = random.uniform(0.0, Tile::kSize);
      leaf.y = random.uniform(0.0, Tile::kSize);
      leaf.half_length = length * random.uniform(0.6, 1.4);
      leaf.half_width = width * random.uniform(0.7, 1.5);
      leaf.direction = static_cast<int>(random.uniform(0.0, kDirections));
      const float below = ground[static_cast<std::size_t>(static_cast<int>(leaf.y) & kMask) * Tile::kSize +
                                 (static_cast<int>(leaf.x) & kMask)];
      leaf.albedo = 0.8F * below + static_cast<float>(random.uniform(-0.9, 1.0));
      leaf.slope = 0.15F;
      paint(canvas, leaf);
    }
  }
  for (int cell = 16; cell >= 2; cell /= 2) add_noise(canvas, Tile::kSize, cell, 0.22F, 400 + cell);
  smooth(canvas, Tile::kSize);
  normalise(canvas, 128.0F, 38.0F);
  return make_tile(std::move(canvas));
}

SolidTexture make_stone() {
  constexpr int n = SolidTexture::kSize;
  Canvas volume(static_cast<std::size_t>(n) * n * n, 0.0F);
  // Octaves of a periodic random lattice, trilinear.
  for (int cell = 16; cell >= 1; cell /= 2) {
    const int m = n / cell;
    const float amplitude = std::pow(static_cast<float>(cell) / 16.0F, 0.35F);
    const auto lattice = [&](int x, int y, int z) {
      const auto key = (static_cast<std::int64_t>(z % m) * m + y % m) * m + x % m;
      return amplitude * static_cast<float>(2.0 * to_unit(hash_cell(900 + cell, key, cell)) - 1.0);
    };
    std::vector<float> values(static_cast<std::size_t>(m) * m * m);
    for (int z = 0; z < m; ++z) {
      for (int y = 0; y < m; ++y)
        for (int x = 0; x < m; ++x) values[(static_cast<std::size_t>(z) * m + y) * m + x] = lattice(x, y, z);
    }
    const auto at = [&](int x, int y, int z) {
      return values[(static_cast<std::size_t>(z % m) * m + y % m) * m + x % m];
    };
    for (int z = 0; z < n; ++z) {
      const float tz = static_cast<float>(z % cell) / static_cast<float>(cell);
      for (int y = 0; y < n; ++y) {
        const float ty = static_cast<float>(y % cell) / static_cast<float>(cell);
        for (int x = 0; x < n; ++x) {
          const float tx = static_cast<float>(x % cell) / static_cast<float>(cell);
          float corner[2][2];
          for (int k = 0; k < 2; ++k) {
            for (int j = 0; j < 2; ++j) {
              const float a = at(x / cell, y / cell + j, z / cell + k);
              corner[k][j] = a + tx * (at(x / cell + 1, y / cell + j, z / cell + k) - a);
            }
          }
          const float a = corner[0][0] + ty * (corner[0][1] - corner[0][0]);
          const float b = corner[1][0] + ty * (corner[1][1] - corner[1][0]);
          volume[(static_cast<std::size_t>(z) * n + y) * n + x] += a + tz * (b - a);
        }
      }
    }
  }
  normalise(volume, 128.0F, 40.0F);
  SolidTexture stone;
  int size = n;
  for (int level = 0;; ++level) {
    stone.level_start.push_back(static_cast<std::uint32_t>(stone.quads.size()));
    for (int z = 0; z < size; ++z) {
      const auto begin = volume.begin() + static_cast<std::ptrdiff_t>(z) * size * size;
      append_quads(stone.quads, Canvas(begin, begin + static_cast<std::ptrdiff_t>(size) * size), size);
    }
    if (level == SolidTexture::kLastLevel) break;
    const int half = size / 2;
    Canvas next(static_cast<std::size_t>(half) * half * half, 0.0F);
    for (int z = 0; z < size; ++z) {
      for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
          next[(static_cast<std::size_t>(z / 2) * half + y / 2) * half + x / 2] +=
              0.125F * volume[(static_cast<std::size_t>(z) * size + y) * size + x];
        }
      }
    }
    volume = std::move(next);
    size = half;
  }
  return stone;
}

double ring_noise(std::uint64_t seed, double azimuth, double rise, double around, double stretch) {
  // On a cylinder, so that it closes: three-dimensional noise would do the same for more.
  const double x = azimuth / (2.0 * std::numbers::pi) * around;
  const auto period = static_cast<std::int64_t>(around);
  const double fx = std::floor(x);
  const double t = x - fx;
  const auto column = [&](std::int64_t c) {
    return gradient_noise(seed + static_cast<std::uint64_t>(((c % period) + period) % period) * 77,
                          0.5 + 0.37 * static_cast<double>(c), rise * stretch);
  };
  const double s = t * t * (3.0 - 2.0 * t);
  const auto c = static_cast<std::int64_t>(fx);
  const double a = column(c % period);
  const double b = column((c + 1) % period);
  return a + s * (b - a);
}

Panorama make_sky() {
  constexpr int w = Panorama::kWidth;
  constexpr int h = Panorama::kHeight;
  Canvas canvas(static_cast<std::size_t>(w) * h);
  // Clouds are smooth: made at an eighth of the resolution.
  constexpr int k = 8;
  Canvas coarse(static_cast<std::size_t>(w / k) * (h / k + 2));
  for (int y = 0; y < h / k + 2; ++y) {
    const double rise =
        static_cast<double>(Panorama::kLowestRise) + static_cast<double>(Panorama::kRiseSpan) * (y * k) / h;
    for (int x = 0; x < w / k; ++x) {
      const double azimuth = 2.0 * std::numbers::pi * x * k / w;
      double cloud = 0.0;
      double amplitude = 1.0;
      double around = 14.0;
      for (std::uint64_t o = 0; o < 5; ++o, amplitude *= 0.55, around *= 2.0)
        cloud += amplitude * ring_noise(5000 + 1000 * o, azimuth, rise, around, around * 0.45);
      cloud = std::clamp(0.5 + 1.3 * cloud, 0.0, 1.0);
      coarse[static_cast<std::size_t>(y) * (w / k) + x] =
          static_cast<float>(188.0 - 60.0 * std::max(rise, 0.0) + 38.0 * cloud * cloud);
    }
  }
  std::vector<float> ridge(w);
  for (int x = 0; x < w; ++x) {
    const double azimuth = 2.0 * std::numbers::pi * x / w;
    double r = 0.028;
    double amplitude = 0.05;
    double around = 9.0;
    for (std::uint64_t o = 0; o < 7; ++o, amplitude *= 0.5, around *= 2.0)
      r += amplitude * ring_noise(9000 + 1000 * o, azimuth, 0.3, around, 1.0);
    ridge[static_cast<std::size_t>(x)] = static_cast<float>(std::max(r, 0.006));
  }
  for (int y = 0; y < h; ++y) {
    const float rise = Panorama::kLowestRise + Panorama::kRiseSpan * static_cast<float>(y) / static_cast<float>(h);
    for (int x = 0; x < w; ++x) {
      const float tx = static_cast<float>(x % k) / k;
      const float ty = static_cast<float>(y % k) / k;
      const float* a = &coarse[static_cast<std::size_t>(y / k) * (w / k)];
      const float* b = a + w / k;
      const int x0 = x / k;
      const int x1 = (x0 + 1) % (w / k);
      const float top = a[x0] + tx * (a[x1] - a[x0]);
      const float bottom = b[x0] + tx * (b[x1] - b[x0]);
      float v = top + ty * (bottom - top);
      // Hills: hazy at their foot, darker and wooded above. A texel is 0.00127 of rise: soft over one of them.
      const float top_of_hill = ridge[static_cast<std::size_t>(x)];
      const float inside = std::clamp((top_of_hill - rise) / 0.0015F + 0.5F, 0.0F, 1.0F);
      if (inside > 0.0F) {
        const float up = std::clamp(rise / 0.03F, 0.0F, 1.0F);
        const double wood =
            up > 0.0F ? 12.0 * gradient_noise(41, 0.08 * x, 0.20 * y) + 7.0 * gradient_noise(42, 0.3 * x, 0.5 * y)
                      : 0.0;
        const float hill = 150.0F - 38.0F * up + static_cast<float>(wood) * up;
        v += inside * (hill - v);
      }
      canvas[static_cast<std::size_t>(y) * w + x] = v;
    }
  }
  Panorama sky;
  sky.quads.reserve(canvas.size());
  for (int y = 0; y < h; ++y) {
    const float* a = &canvas[static_cast<std::size_t>(y) * w];
    const float* b = &canvas[static_cast<std::size_t>(std::min(y + 1, h - 1)) * w];
    for (int x = 0; x < w; ++x) {
      const int xr = (x + 1) % w;
      sky.quads.push_back(quad(byte(a[x]), byte(a[xr]), byte(b[x]), byte(b[xr])));
    }
  }
  return sky;
}

}  // namespace

const Textures& textures() {
  static const Textures kMade = [] {
    Textures t;
    // What one of them throws (no memory) comes out of get().
    auto gravel = std::async(std::launch::async, make_gravel);
    auto sky = std::async(std::launch::async, [] { return std::pair(make_sky(), make_stone()); });
    t.grass = make_grass();
    t.gravel = gravel.get();
    std::tie(t.sky, t.stone) = sky.get();
    return t;
  }();
  return kMade;
}

}  // namespace cliquevo::drivers::sim
