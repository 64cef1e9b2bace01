// SPDX-License-Identifier: BSD-3-Clause
// Every vector kernel against the plain one, bit for bit, on random data in poisoned memory.
#include <algorithm>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/image.h"
#include "stereo/kernels/kernels.h"

namespace cliquevo::stereo::kernels {
namespace {

class KernelTest : public ::testing::TestWithParam<Isa> {
 protected:
  const Table& tested() const { return *tables().find(GetParam()); }
};

int below(std::mt19937& random, int limit) { return static_cast<int>(random() % static_cast<unsigned>(limit)); }

// A matching image with poison in its margins.
struct Padded {
  int stride;
  std::vector<std::uint8_t> data;
  Padded(int width, int height, int slack, int highest, int poison, std::mt19937& random)
      : stride(width + 2 * kMargin + slack), data(static_cast<std::size_t>(stride * height)) {
    for (auto& v : data) v = static_cast<std::uint8_t>(below(random, poison + 1));
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) pixel(y)[x] = static_cast<std::uint8_t>(below(random, highest + 1));
    }
  }
  std::uint8_t* pixel(int y) { return data.data() + y * stride + kMargin; }
};

struct Found {
  std::vector<std::uint16_t> cells = std::vector<std::uint16_t>(MatchRow::kRows * MatchRow::kStride, 7);
  MatchRow row() { return {cells.data()}; }
};

struct Shape {
  int width, height, window, window_height, min_disparity, num_disparities;
};

MatchJob job_of(const Shape& s, unsigned seed, Padded& left, Padded& right, Padded& other) {
  MatchJob job{};
  job.left = left.pixel(0);
  job.right[0] = right.pixel(0);
  job.right[1] = other.pixel(0);
  job.stride = left.stride;
  job.channels = seed % 3 == 0 ? Channels::horizontal : Channels::checkered;
  job.width = s.width;
  job.height = s.height;
  job.window = s.window;
  job.window_height = s.window_height;
  job.min_disparity = s.min_disparity;
  job.num_disparities = s.num_disparities;
  job.second = seed % 3 != 1;
  return job;
}

void compare_row(const MatchRow& a, const MatchRow& b, int width, bool second) {
  for (int x = 0; x < width; ++x) {
    ASSERT_EQ(a.disparity()[x], b.disparity()[x]) << x;
    if (a.disparity()[x] == kUnknownDisparity) continue;
    ASSERT_EQ(a.best()[x], b.best()[x]) << x;
    ASSERT_EQ(a.below()[x], b.below()[x]) << x;
    ASSERT_EQ(a.above()[x], b.above()[x]) << x;
    if (second) {
      ASSERT_EQ(a.second()[x], b.second()[x]) << x;
    }
  }
}

void compare(const Table& tested, const Shape& s, unsigned seed) {
  SCOPED_TRACE(std::to_string(s.width) + "x" + std::to_string(s.height) + " window " + std::to_string(s.window) + "x" +
               std::to_string(s.window_height) + " disparities " + std::to_string(s.min_disparity) + "+" +
               std::to_string(s.num_disparities) + " seed " + std::to_string(seed));
  std::mt19937 random(seed);
  const int range = matching_range(s.window, s.window_height, s.num_disparities);
  // Few grey levels make ties; the extremes make the sums as large as they can be.
  const int highest = seed % 2 == 0 ? 2 * range : 1;
  Padded left(s.width, s.height, static_cast<int>(seed % 5), highest, 2 * range, random);
  Padded right(s.width, s.height, static_cast<int>(seed % 5), highest, 2 * range, random);
  Padded other(s.width, s.height, static_cast<int>(seed % 5), highest, 2 * range, random);
  if (seed % 4 == 1) {  // the largest differences there are
    for (Padded* p : {&left, &right, &other}) {
      for (int y = 0; y < s.height; ++y) {
        for (int x = 0; x < s.width; ++x) p->pixel(y)[x] = static_cast<std::uint8_t>(p->pixel(y)[x] * 2 * range);
      }
    }
  }
  const std::size_t cells = column_cells(s.width, s.num_disparities);
  Image<std::uint8_t> columns_a(static_cast<int>(cells), 1), columns_b(static_cast<int>(cells), 1);
  Image<std::uint16_t> costs_a(static_cast<int>(cost_cells(s.num_disparities)), 1);
  Image<std::uint16_t> costs_b(static_cast<int>(cost_cells(s.num_disparities)), 1);
  columns_b.fill(0xAB);
  costs_b.fill(0xABCD);
  static Found found_a, found_b;
  const MatchRow a = found_a.row();
  const MatchRow b = found_b.row();
  MatchJob job = job_of(s, seed, left, right, other);
  MatchJob same = job;
  job.columns = columns_a.view().data;
  job.costs = costs_a.view().data;
  job.out = a;
  same.columns = columns_b.view().data;
  same.costs = costs_b.view().data;
  same.out = b;
  job.step = same.step = seed % 5 < 2 ? -1 : 1;
  for (int row = 0; row < s.height; ++row) {
    const int y = job.step > 0 ? row : s.height - 1 - row;
    job.y = same.y = y;
    job.first = same.first = row % 5 == 0;
    kReference.match_row(job);
    tested.match_row(same);
    SCOPED_TRACE(y);
    compare_row(a, b, s.width, job.second);
  }
}

TEST_P(KernelTest, MatchRowEqualsTheReference) {
#if defined(__aarch64__)
  constexpr unsigned kEvery = 3;  // emulated: slow
#else
  constexpr unsigned kEvery = 1;
#endif
  unsigned seed = 1;
  unsigned round = 0;
  for (const int window : {5, 7, 9, 11, 13, 15, 17, 19, 21}) {
    for (const int n : {16, 32, 48, 64, 80, 96, 112, 128, 144, 160, 176, 192, 208, 224, 240, 256}) {
      if (++round % kEvery != 0) continue;
      const int tall = std::min(21, 3 + 2 * static_cast<int>(seed % 10));
      compare(tested(), {window, window, window, window, -2, n}, ++seed);
      compare(tested(), {window + 1, 6, window, 5, -2, n}, ++seed);
      const int odd = static_cast<int>(seed % 9);
      compare(tested(), {n + 2 * window + odd, tall, window, tall, 3, n}, ++seed);
      const int below = static_cast<int>(seed % 20);
      compare(tested(), {n + 37, window + 2, window, window, -below, n}, ++seed);
    }
  }
}

TEST_P(KernelTest, PrefilterEqualsTheReference) {
  std::mt19937 random(3);
  for (int width = 1; width < 140; ++width) {
    std::vector<std::uint8_t> image(static_cast<std::size_t>(3 * width));
    for (auto& v : image) v = static_cast<std::uint8_t>(width % 3 == 0 ? 255 * below(random, 2) : below(random, 256));
    const int range = 1 + below(random, 9);
    const int cap = 1 + below(random, 63);
    const auto slope = static_cast<std::uint16_t>(range * 4096 / cap);
    const Curve linear{{static_cast<std::uint16_t>(cap), 0, 0}, {slope, 0, 0}, range};
    const Curve concave{{12, 40, 160}, {1345, 446, 86}, 9};
    const PrefilterRow in{image.data(), image.data() + width, image.data() + 2 * width, width,
                          width % 2 == 0 ? linear : concave};
    const auto cells = static_cast<std::size_t>(width + 2);
    for (const Channels channels : {Channels::horizontal, Channels::checkered}) {
      std::vector<std::uint8_t> a[4], b[4];
      for (int i = 0; i < 4; ++i) {
        a[i].assign(cells, 0xCD);
        b[i].assign(cells, 0xCD);
      }
      const int y = below(random, 9);
      kReference.prefilter_left(in, channels, y, cap, a[0].data() + 1, a[1].data() + 1);
      kReference.prefilter_right(in, a[2].data() + 1, a[3].data() + 1);
      tested().prefilter_left(in, channels, y, cap, b[0].data() + 1, b[1].data() + 1);
      tested().prefilter_right(in, b[2].data() + 1, b[3].data() + 1);
      for (int i = 0; i < 4; ++i) ASSERT_EQ(a[i], b[i]) << "plane " << i << " width " << width;
    }
  }
}

TEST_P(KernelTest, TextureEqualsTheReference) {
  std::mt19937 random(6);
  for (int width = 5; width < 160; ++width) {
    const auto n = static_cast<std::size_t>(width);
    std::vector<std::uint8_t> added(n), removed(n);
    std::vector<std::uint16_t> columns(n), sums_a(n, 7), sums_b(n, 7);
    for (std::size_t x = 0; x < n; ++x) {
      added[x] = static_cast<std::uint8_t>(below(random, 127));
      removed[x] = static_cast<std::uint8_t>(below(random, 127));
      columns[x] = static_cast<std::uint16_t>(63 + below(random, 1200));
    }
    std::vector<std::uint16_t> same = columns;
    const int radius = 2 + below(random, std::max(1, std::min(9, (width - 1) / 2 - 1)));
    kReference.texture_columns(added.data(), removed.data(), 63, width, columns.data());
    tested().texture_columns(added.data(), removed.data(), 63, width, same.data());
    ASSERT_EQ(columns, same) << width;
    kReference.texture_sums(columns.data(), width, radius, sums_a.data());
    tested().texture_sums(columns.data(), width, radius, sums_b.data());
    ASSERT_EQ(sums_a, sums_b) << width;
  }
}

TEST_P(KernelTest, FinishingEqualsTheReference) {
  std::mt19937 random(5);
  static Found cells;
  for (int width = 1; width < 160; ++width) {
    const MatchRow row = cells.row();
    std::vector<std::int16_t> astray(static_cast<std::size_t>(width));
    std::vector<std::uint16_t> texture(static_cast<std::size_t>(width));
    for (int x = 0; x < width; ++x) {
      row.disparity()[x] =
          below(random, 5) == 0 ? kUnknownDisparity : static_cast<std::int16_t>(below(random, 320) - 64);
      const int best = below(random, below(random, 2) == 0 ? 8 : 16000);
      row.best()[x] = static_cast<std::uint16_t>(best);
      row.below()[x] = static_cast<std::uint16_t>(best + below(random, 383));
      row.above()[x] = static_cast<std::uint16_t>(best + below(random, 383));
      row.second()[x] = static_cast<std::uint16_t>(best + below(random, 383));
      astray[static_cast<std::size_t>(x)] = static_cast<std::int16_t>(below(random, 9) - 4);
      texture[static_cast<std::size_t>(x)] = static_cast<std::uint16_t>(below(random, 400));
    }
    FinishRow in{row, astray.data(), texture.data(), width, 0, 0, 0};
    in.uniqueness_percent = below(random, 2) * below(random, 101);
    in.texture_threshold = below(random, 2) * 200;
    in.left_right_tolerance = below(random, 4) - 1;
    std::vector<std::int16_t> a(static_cast<std::size_t>(width + 1), 99), b = a;
    kReference.finish_row(in, a.data());
    tested().finish_row(in, b.data());
    ASSERT_EQ(a, b) << width;
  }
}

TEST_P(KernelTest, TheLeftRightCheckEqualsTheReference) {
  std::mt19937 random(9);
  static Found cells;
  for (int width = 1; width < 160; ++width) {
    const MatchRow row = cells.row();
    int d = 0;
    for (int x = 0; x < width; ++x) {
      if (below(random, 1 + width % 20) == 0) d = below(random, 40) - 10;
      const bool inside = x - d >= 0 && x - d < width;
      row.disparity()[x] =
          inside && below(random, 1 + width % 30) != 0 ? static_cast<std::int16_t>(d) : kUnknownDisparity;
      row.best()[x] = static_cast<std::uint16_t>(below(random, 16384));
    }
    const auto n = static_cast<std::size_t>(width);
    std::vector<std::uint32_t> partner_a(3 * n + 1, 7), partner_b(3 * n + 1, 7);
    std::vector<std::int16_t> a(n + 1, 99), b = a;
    kReference.cross_check({row, width, partner_a.data(), a.data()});
    tested().cross_check({row, width, partner_b.data(), b.data()});
    for (int x = 0; x < width; ++x) {
      if (row.disparity()[x] == kUnknownDisparity) continue;
      ASSERT_EQ(a[x], b[x]) << x << " of " << width;
    }
    ASSERT_EQ(b[n], 99);
    ASSERT_EQ(partner_b[3 * n], 7U);
  }
}

TEST_P(KernelTest, LinkingEqualsTheReference) {
  std::mt19937 random(7);
  for (int width = 1; width < 300; ++width) {
    // Nothing may be read beside the rows, nor written behind their last word.
    std::vector<std::int16_t> row(static_cast<std::size_t>(width)), above = row;
    for (auto* r : {&row, &above}) {
      for (auto& v : *r) {
        v = below(random, 5) == 0 ? kUnknownDisparity : static_cast<std::int16_t>(below(random, 40) - 20);
        if (below(random, 9) == 0) v = static_cast<std::int16_t>(below(random, 2) == 0 ? 5119 : -1024);
      }
    }
    const auto words = static_cast<std::size_t>(width + 63) / 64 + 1;
    std::vector<std::uint64_t> a[3], b[3];
    for (int i = 0; i < 3; ++i) {
      a[i].assign(words, 0x1234);
      b[i].assign(words, 0x1234);
    }
    const int range = 16 * below(random, 3);
    kReference.link_row({row.data(), above.data(), width, range, a[0].data(), a[1].data(), a[2].data()});
    tested().link_row({row.data(), above.data(), width, range, b[0].data(), b[1].data(), b[2].data()});
    for (int i = 0; i < 3; ++i) ASSERT_EQ(a[i], b[i]) << "bits " << i << " width " << width;
  }
}

// Maps whose blocks are compact, scattered, and partly without a source.
TEST_P(KernelTest, RectifyingEqualsTheReference) {
  std::mt19937 random(8);
  for (int width = 1; width < 120; ++width) {
    const int raw_width = 16 + below(random, 60);
    const int raw_height = 3 + below(random, 20);
    const int stride = raw_width + below(random, 3);
    std::vector<std::uint8_t> raw(static_cast<std::size_t>(stride * raw_height));
    for (auto& v : raw) v = static_cast<std::uint8_t>(width % 3 == 0 ? 255 * below(random, 2) : below(random, 256));
    const auto n = static_cast<std::size_t>(width);
    const int blocks = width / RemapRow::kBlock;
    std::vector<std::int16_t> xs(n), ys(n);
    std::vector<std::uint8_t> weight_x(n), weight_y(n), at(n);
    std::vector<RemapRow::Patch> patches(static_cast<std::size_t>(blocks) + 1, {-1, -1});
    for (std::size_t i = 0; i < n; ++i) {
      const std::size_t block = i / RemapRow::kBlock;
      RemapRow::Patch& patch = patches[block];
      if (i % RemapRow::kBlock == 0 && static_cast<int>(block) < blocks && below(random, 4) != 0) {
        patch = {static_cast<std::int16_t>(below(random, raw_width - RemapRow::Patch::kWidth + 1)),
                 static_cast<std::int16_t>(below(random, raw_height - RemapRow::Patch::kHeight + 1))};
      }
      weight_x[i] = static_cast<std::uint8_t>(below(random, 65));
      weight_y[i] = static_cast<std::uint8_t>(below(random, 65));
      if (static_cast<int>(block) < blocks && patch.x >= 0) {
        const int column = below(random, RemapRow::Patch::kWidth - 1);
        const int line = below(random, 2);
        xs[i] = static_cast<std::int16_t>(patch.x + column);
        ys[i] = static_cast<std::int16_t>(patch.y + line);
        at[i] = static_cast<std::uint8_t>(column + 128 * line);
      } else {
        xs[i] = static_cast<std::int16_t>(below(random, raw_width) - 1);
        ys[i] = static_cast<std::int16_t>(xs[i] < 0 ? -1 : below(random, raw_height - 1));
      }
    }
    const RemapRow map{xs.data(), ys.data(), weight_x.data(), weight_y.data(), patches.data(), at.data()};
    std::vector<std::uint8_t> a(n + 1, 0xCD), b = a;
    kReference.remap_row(raw.data(), stride, map, width, a.data());
    tested().remap_row(raw.data(), stride, map, width, b.data());
    ASSERT_EQ(a, b) << width;
  }
}

TEST_P(KernelTest, SmoothingEqualsTheReference) {
  std::mt19937 random(4);
  for (int width = 1; width < 120; ++width) {
    std::vector<std::vector<std::int16_t>> rows(7, std::vector<std::int16_t>(static_cast<std::size_t>(width)));
    for (auto& row : rows) {
      for (auto& v : row) {
        v = below(random, 4) == 0 ? kUnknownDisparity : static_cast<std::int16_t>(below(random, 80) - 40);
        if (below(random, 9) == 0) v = static_cast<std::int16_t>(below(random, 2) == 0 ? 5119 : -1024);
      }
    }
    for (const bool finer : {true, false}) {
      SmoothRow in{rows[0].data(), {}, 2 * (1 + below(random, 3)), 16, 4, 0, 0};
      if (!finer) in = {rows[0].data(), {}, in.neighbours, 64, 1, 2, 2};
      for (int i = 0; i < 6; ++i) in.neighbour[i] = rows[i + 1].data();
      std::vector<std::int16_t> a(static_cast<std::size_t>(width + 1), 99), b = a;
      kReference.smooth_row(in, width, a.data());
      tested().smooth_row(in, width, b.data());
      ASSERT_EQ(a, b) << width;
    }
  }
}

// All but the reference itself.
std::vector<Isa> tested_sets() {
  std::vector<Isa> out = tables().usable();
  out.erase(out.begin());
  return out;
}

INSTANTIATE_TEST_SUITE_P(Isa, KernelTest, ::testing::ValuesIn(tested_sets()),
                         [](const auto& param_info) { return std::string(isa_name(param_info.param)); });

}  // namespace
}  // namespace cliquevo::stereo::kernels
