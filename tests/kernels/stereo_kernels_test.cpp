// SPDX-License-Identifier: BSD-3-Clause
// Every vector kernel against the plain one, bit for bit, on random data in poisoned memory.
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
  void SetUp() override {
    if (!isa_available(GetParam())) GTEST_SKIP() << "this machine has no " << isa_name(GetParam());
    ASSERT_EQ(table(GetParam()).isa, GetParam());
  }
};

// A matching image with poison in its margins.
struct Padded {
  int stride;
  std::vector<std::uint8_t> data;
  Padded(int width, int height, int slack, int highest, std::mt19937& random)
      : stride(width + 2 * kMargin + slack), data(static_cast<std::size_t>(stride * height)) {
    for (auto& v : data) v = static_cast<std::uint8_t>(random() & 127);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x)
        pixel(y)[x] = static_cast<std::uint8_t>(static_cast<int>(random()) % (highest + 1) & 127);
    }
  }
  std::uint8_t* pixel(int y) { return data.data() + y * stride + kMargin; }
};

struct Found {
  std::vector<std::int16_t> disparity;
  std::vector<std::uint16_t> best, below, above, second;
  explicit Found(int n) : disparity(n, 7), best(n, 7), below(n, 7), above(n, 7), second(n, 7) {}
  MatchRow row() { return {disparity.data(), best.data(), below.data(), above.data(), second.data()}; }
};

struct Shape {
  int width, height, window, min_disparity, num_disparities;
};

void compare(const Table& tested, const Shape& s, unsigned seed) {
  SCOPED_TRACE(std::string(isa_name(tested.isa)) + " " + std::to_string(s.width) + "x" + std::to_string(s.height) +
               " window " + std::to_string(s.window) + " disparities " + std::to_string(s.min_disparity) + "+" +
               std::to_string(s.num_disparities) + " seed " + std::to_string(seed));
  std::mt19937 random(seed);
  const int range = matching_range(s.window, seed % 3 == 0 ? 63 : 31);
  // Few grey levels make ties; the whole range makes the sums as large as they can be.
  const int highest = seed % 2 == 0 ? 2 * range : 3;
  Padded left(s.width, s.height, static_cast<int>(seed % 5), highest, random);
  Padded right(s.width, s.height, static_cast<int>(seed % 5), highest, random);
  for (int y = 0; y < s.height; ++y) {
    for (int x = 0; x < s.width; ++x) {
      left.pixel(y)[x] = static_cast<std::uint8_t>(std::min<int>(left.pixel(y)[x], 2 * range));
      right.pixel(y)[x] = static_cast<std::uint8_t>(std::min<int>(right.pixel(y)[x], 2 * range));
    }
  }
  const std::size_t cells = static_cast<std::size_t>(s.width) * padded_disparities(s.num_disparities) + 512;
  std::vector<std::uint8_t> columns_a(cells), columns_b(cells, 0xAB);
  std::vector<std::uint16_t> costs_a(cells), costs_b(cells, 0xABCD);
  Found a(s.width), b(s.width);
  MatchJob job{left.pixel(0),   right.pixel(0),    left.stride, s.width, s.height,         s.window,
               s.min_disparity, s.num_disparities, 0,           true,    columns_a.data(), costs_a.data(),
               a.row()};
  MatchJob same = job;
  same.columns = columns_b.data();
  same.costs = costs_b.data();
  same.out = b.row();
  for (int y = 0; y < s.height; ++y) {
    job.y = same.y = y;
    job.first = same.first = y % 7 == 0;
    kReference.match_row(job);
    tested.match_row(same);
    for (int x = 0; x < s.width; ++x) {
      ASSERT_EQ(a.disparity[x], b.disparity[x]) << x << "," << y;
      if (a.disparity[x] == kUnknownDisparity) continue;
      ASSERT_EQ(a.best[x], b.best[x]) << x << "," << y;
      ASSERT_EQ(a.below[x], b.below[x]) << x << "," << y;
      ASSERT_EQ(a.above[x], b.above[x]) << x << "," << y;
      ASSERT_EQ(a.second[x], b.second[x]) << x << "," << y;
    }
  }
}

TEST_P(KernelTest, MatchRowEqualsTheReference) {
  const Table& tested = table(GetParam());
  unsigned seed = 1;
  for (const int window : {5, 7, 9, 11, 13, 15, 17, 19, 21}) {
    for (const int n : {16, 32, 48, 64, 80, 96, 128, 144, 256}) {
      const int more = static_cast<int>(seed % 9);
      const int below_zero = static_cast<int>(seed % 20);
      compare(tested, {window + 1, window + 1, window, -2, n}, ++seed);
      compare(tested, {n + 2 * window + more, window, window, 3, n}, ++seed);
      compare(tested, {n + 37, window + 4, window, -below_zero, n}, ++seed);
    }
  }
}

#if defined(__aarch64__)
const auto kTested = ::testing::Values(Isa::neon);
#else
const auto kTested = ::testing::Values(Isa::sse4, Isa::avx2);
#endif

INSTANTIATE_TEST_SUITE_P(Isa, KernelTest, kTested,
                         [](const auto& param_info) { return std::string(isa_name(param_info.param)); });

}  // namespace
}  // namespace cliquevo::stereo::kernels
