// SPDX-License-Identifier: BSD-3-Clause
#include <cstring>
#include <memory>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/image.h"
#include "core/vo/kernels/kernels.h"
#include "core/vo/patch.h"

namespace cliquevo::vo {
namespace {

class VoKernels : public testing::TestWithParam<Isa> {};

TEST_P(VoKernels, FindTheReferencesCornersWithItsScoresOnEveryWidthAndThreshold) {
  std::mt19937 rng(7);
  const Kernels& reference = kernel_tables().reference();
  const Kernels& kernel = *kernel_tables().find(GetParam());
  for (const int width : {7, 8, 23, 38, 39, 40, 71, 130}) {
    for (const int threshold : {1, 4, 20, 60, 128, 250}) {
      // Blocky random pictures, else chance gives no nine equal neighbours.
      Image<std::uint8_t> image(width, 31);
      for (int y = 0; y < 31; ++y) {
        for (int x = 0; x < width; ++x) {
          image.view()(x, y) =
              (x % 5 == 0 || y % 4 == 0 || x == 0) ? static_cast<std::uint8_t>(rng() % 256) : image.view()(x - 1, y);
        }
      }
      for (int y = 3; y < 28; ++y) {
        std::vector<std::uint8_t> scores_a(static_cast<std::size_t>(width), 7), scores_b = scores_a;
        const auto view = image.cview();
        reference.fast_row(view.row(y), view.stride, 3, width - 3, threshold, scores_a.data());
        kernel.fast_row(view.row(y), view.stride, 3, width - 3, threshold, scores_b.data());
        ASSERT_EQ(scores_a, scores_b) << "width " << width << " threshold " << threshold << " row " << y;
        EXPECT_EQ(scores_b[2], 7) << "before the first";
        EXPECT_EQ(scores_b[static_cast<std::size_t>(width) - 3], 7) << "behind the last";
      }
    }
  }
}

TEST_P(VoKernels, FindTheReferencesMaximaAlsoAmongEquals) {
  std::mt19937 rng(13);
  const Kernels& reference = kernel_tables().reference();
  const Kernels& kernel = *kernel_tables().find(GetParam());
  for (const int width : {3, 17, 18, 33, 34, 35, 66, 131}) {
    for (const unsigned levels : {2U, 5U, 256U}) {
      std::vector<std::uint8_t> rows(3 * static_cast<std::size_t>(width));
      for (int trial = 0; trial < 30; ++trial) {
        for (auto& s : rows) s = static_cast<std::uint8_t>(rng() % 3 == 0 ? rng() % levels : 0);
        std::vector<std::int16_t> columns_a(static_cast<std::size_t>(width)), columns_b = columns_a;
        const std::uint8_t* above = rows.data();
        const auto run = [&](const Kernels& k, std::vector<std::int16_t>& columns) {
          columns.resize(static_cast<std::size_t>(
              k.maxima_row(above, above + width, above + 2 * width, 1, width - 1, columns.data())));
        };
        run(reference, columns_a);
        run(kernel, columns_b);
        ASSERT_EQ(columns_a, columns_b) << "width " << width;
        if (width > 100) {
          EXPECT_FALSE(columns_a.empty());
        }
      }
    }
  }
}

TEST_P(VoKernels, FindTheReferencesConsistentMatches) {
  std::mt19937 rng(14);
  std::normal_distribution<float> coordinate(0.0F, 5.0F), error(0.0F, 0.05F);
  const Kernels& reference = kernel_tables().reference();
  const Kernels& kernel = *kernel_tables().find(GetParam());
  for (const int count : {1, 7, 8, 9, 64, 131}) {
    constexpr std::size_t kStride = 136;
    std::vector<float> storage(kStride * kGraphFields);
    for (auto& v : storage) v = error(rng);
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        storage[(kAx + k) * kStride + i] = coordinate(rng);
        storage[(kBx + k) * kStride + i] = storage[(kAx + k) * kStride + i] + error(rng);
      }
      storage[kLateral * kStride + i] = 1e-4F;
    }
    if (count > 8) {  // one point twice: its distance is none
      for (std::size_t f = 0; f < kGraphFields; ++f) storage[f * kStride + 8] = storage[f * kStride];
    }
    GraphNodes nodes{};
    nodes.count = count;
    for (std::size_t f = 0; f < kGraphFields; ++f) nodes.field[f] = storage.data() + f * kStride;
    std::vector<std::vector<std::uint8_t>> rows;
    for (const float sigmas2 : {0.0F, 9.0F}) {
      const GraphTest test{0.0025F, sigmas2};
      for (int i = 0; i < count; ++i) {
        std::vector<std::uint8_t> a(18, 0x55), b = a;
        reference.graph_row(nodes, i, test, a.data());
        kernel.graph_row(nodes, i, test, b.data());
        ASSERT_EQ(a, b) << count << " nodes, node " << i;
        if (sigmas2 > 0.0F) rows.push_back(b);
      }
    }
    const auto consistent = [&](int i, int j) {
      return (rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j) / 8] >> (j % 8) & 1) != 0;
    };
    for (int i = 0; i < count; ++i) {
      for (int j = 0; j < count; ++j) EXPECT_EQ(consistent(i, j), consistent(j, i));
      EXPECT_TRUE(consistent(i, i));
    }
  }
}

TEST_P(VoKernels, SumTheReferencesAbsoluteDifferences) {
  std::mt19937 rng(8);
  const Kernels& reference = kernel_tables().reference();
  const Kernels& kernel = *kernel_tables().find(GetParam());
  for (const int length : {24, 48, 80, 120}) {
    for (const int count : {0, 1, 2, 17, 100}) {
      Image<std::uint8_t> others(kDescriptorStride, count + 1);
      others.fill(0);
      for (int i = 0; i <= count; ++i) {
        for (int k = 0; k < length; ++k) others.view()(k, i) = static_cast<std::uint8_t>(rng() % 256);
      }
      std::vector<std::uint16_t> a(static_cast<std::size_t>(count) + 1), b = a;
      const std::uint8_t* one = others.cview().row(count);
      reference.sad_row(one, others.cview().data, count + 1, length, a.data());
      kernel.sad_row(one, others.cview().data, count + 1, length, b.data());
      EXPECT_EQ(a, b);
      EXPECT_EQ(a.back(), 0) << "a descriptor differs from itself";
    }
  }
}

TEST_P(VoKernels, FindTheReferencesMinimaOfRowsAndColumns) {
  std::mt19937 rng(12);
  const Kernels& reference = kernel_tables().reference();
  const Kernels& kernel = *kernel_tables().find(GetParam());
  for (const int count : {1, 7, 8, 15, 16, 17, 33, 100}) {
    for (const unsigned range : {3U, 40U, 65536U}) {
      const auto n = static_cast<std::size_t>(count);
      std::vector<std::uint16_t> scores(n), score_a(n, 0xFFFF), score_b = score_a;
      std::vector<std::int16_t> best_a(n, -1), best_b = best_a;
      for (int row = 0; row < 20; ++row) {
        for (auto& s : scores) s = static_cast<std::uint16_t>(65535U - rng() % range);
        ASSERT_EQ(reference.row_minimum(scores.data(), count, row, score_a.data(), best_a.data()),
                  kernel.row_minimum(scores.data(), count, row, score_b.data(), best_b.data()));
        ASSERT_EQ(score_a, score_b);
        ASSERT_EQ(best_a, best_b);
      }
    }
  }
}

TEST_P(VoKernels, SampleAndSumPatchesToTheReferencesBits) {
  std::mt19937 rng(9);
  std::uniform_real_distribution<float> place(20.0F, 40.0F), near(0.8F, 1.2F), off(-0.3F, 0.3F);
  const Kernels& reference = kernel_tables().reference();
  const Kernels& kernel = *kernel_tables().find(GetParam());
  Image<std::uint8_t> image(61, 63);
  for (int y = 0; y < 63; ++y) {
    for (int x = 0; x < 61; ++x) image.view()(x, y) = static_cast<std::uint8_t>(rng() % 256);
  }
  for (int radius = 2; radius <= kMaxPatchRadius; ++radius) {
    Template found;
    ASSERT_TRUE(cut_template(image.cview(), 30.25F, 31.5F, radius, found));
    PatchGrid grid{};
    grid.radius = radius;
    grid.side = 2 * radius + 3;
    grid.row = (2 * radius + kPatchLanes) / kPatchLanes * kPatchLanes;
    for (int i = 0; i < grid.side * grid.side; ++i) {
      grid.dx[i] = static_cast<float>(i % grid.side - radius - 1);
      const int row = i / grid.side;
      grid.dy[i] = static_cast<float>(row - radius - 1);
    }
    for (int i = 0; i < 2 * radius + 1; ++i) grid.inside[i] = 1.0F;
    const std::uint8_t* const corner = image.cview().row(30 - radius) + 29 - radius;
    for (int trial = 0; trial < 50; ++trial) {
      const PatchPlace p{place(rng), place(rng), near(rng), off(rng), off(rng), near(rng)};
      PatchSums sa{}, sb{};
      reference.patch_sums(grid, image.cview().data, image.cview().stride, p, found.inner, sa);
      kernel.patch_sums(grid, image.cview().data, image.cview().stride, p, found.inner, sb);
      ASSERT_EQ(0, std::memcmp(&sa, &sb, sizeof sa)) << "radius " << radius;
      EXPECT_GT(sa.gxx, 0.0F);
      PatchSums across_a{}, across_b{};
      reference.patch_sums_across(grid, image.cview().data, image.cview().stride, p, found.inner, across_a);
      kernel.patch_sums_across(grid, image.cview().data, image.cview().stride, p, found.inner, across_b);
      ASSERT_EQ(0, std::memcmp(&across_a, &across_b, sizeof across_a)) << "radius " << radius;
      ASSERT_EQ(across_a.gxw, sa.gxw);
      ASSERT_EQ(across_a.tw, sa.tw);
      // On whole pixels, to the right of them, below them, and between.
      const float right = trial % 4 == 0 || trial % 4 == 2 ? 0.0F : p.x - std::floor(p.x);
      const float down = trial % 4 < 2 ? 0.0F : p.y - std::floor(p.y);
      const auto inner_a = std::make_unique<PatchInner>(), inner_b = std::make_unique<PatchInner>();
      reference.patch_cut(grid, corner, image.cview().stride, right, down, *inner_a);
      kernel.patch_cut(grid, corner, image.cview().stride, right, down, *inner_b);
      ASSERT_EQ(0, std::memcmp(inner_a.get(), inner_b.get(), sizeof *inner_a)) << "radius " << radius;
      // Where it was cut from, the image is the template.
      PatchSums own{};
      const PatchPlace there{30.0F + right, 31.0F + down, 1.0F, 0.0F, 0.0F, 1.0F};
      reference.patch_sums(grid, image.cview().data, image.cview().stride, there, *inner_a, own);
      EXPECT_NEAR(own.tw, inner_a->tt, 1e-4F * inner_a->tt);
      EXPECT_NEAR(own.ww, inner_a->tt, 1e-4F * inner_a->tt);
      EXPECT_NEAR(own.w, 0.0F, 1.0F);
    }
  }
}

TEST_P(VoKernels, SumTheReferencesNormalEquationsToTheBit) {
  std::mt19937 rng(10);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const Kernels& reference = kernel_tables().reference();
  const Kernels& kernel = *kernel_tables().find(GetParam());
  for (const int count : {0, 4, 40, 400}) {
    std::vector<double> a(static_cast<std::size_t>(kMotionFields) * 400), b;
    MotionTerms terms{};
    terms.count = count;
    for (std::size_t f = 0; f < kMotionFields; ++f) {
      for (std::size_t i = 0; i < 400; ++i) a[f * 400 + i] = 5.0 + u(rng) + (f == kQz || f == kPz ? 7.0 * u(rng) : 0.0);
    }
    for (std::size_t i = 0; i < 400; ++i) a[kActive * 400 + i] = i % 3 == 0 ? 0.0 : 1.0;
    b = a;
    MotionState state{};
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 3; ++c) state.R[r][c] = state.M[r][c] = (r == c ? 1.0 : 0.0) + 0.01 * u(rng);
      state.t[r] = state.m[r] = 0.1 * u(rng);
    }
    state.fx = state.fy = 3.0, state.cx = state.cy = 2.0, state.fx_baseline = 1.0, state.doffs = 0.5;
    state.weight_px = 2.0, state.weight_d = 1.0, state.variance_d = 1.0, state.huber = 1.5, state.min_depth = 1e-3;
    state.shift = 0.01;
    MotionSums sa{}, sb{};
    const auto run = [&](const Kernels& k, std::vector<double>& storage, MotionSums& sums) {
      for (std::size_t f = 0; f < kMotionFields; ++f) terms.field[f] = storage.data() + f * 400;
      k.motion_sums(terms, state, sums);
    };
    run(reference, a, sa);
    run(kernel, b, sb);
    EXPECT_EQ(0, std::memcmp(&sa, &sb, sizeof sa)) << count;
    EXPECT_EQ(a, b) << "squared sigmas";
    EXPECT_EQ(count > 0, sa.H[0] > 0.0);
  }
}

// All but the reference itself.
std::vector<Isa> tested_sets() {
  std::vector<Isa> out = kernel_tables().usable();
  out.erase(out.begin());
  return out;
}

INSTANTIATE_TEST_SUITE_P(Isa, VoKernels, testing::ValuesIn(tested_sets()),
                         [](const auto& param_info) { return std::string(isa_name(param_info.param)); });

}  // namespace
}  // namespace cliquevo::vo
