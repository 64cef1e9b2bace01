// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/kernels/kernels.h"

#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/image.h"

namespace cliquevo::vo {
namespace {

class VoKernels : public testing::TestWithParam<Isa> {
 protected:
  void SetUp() override {
    if (kernels_for(GetParam()) == nullptr) GTEST_SKIP() << isa_name(GetParam()) << " is not on this machine";
  }
};

TEST_P(VoKernels, FindTheReferencesCornersWithItsScoresOnEveryWidthAndThreshold) {
  std::mt19937 rng(7);
  const Kernels& reference = *kernels_for(Isa::reference);
  const Kernels& kernel = *kernels_for(GetParam());
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
        std::vector<std::int16_t> columns_a(static_cast<std::size_t>(width)), columns_b = columns_a;
        std::vector<std::uint8_t> scores_a(static_cast<std::size_t>(width)), scores_b = scores_a;
        const auto view = image.cview();
        const int a =
            reference.fast_row(view.row(y), view.stride, 3, width - 3, threshold, columns_a.data(), scores_a.data());
        const int b =
            kernel.fast_row(view.row(y), view.stride, 3, width - 3, threshold, columns_b.data(), scores_b.data());
        ASSERT_EQ(a, b) << "width " << width << " threshold " << threshold << " row " << y;
        columns_a.resize(static_cast<std::size_t>(a));
        columns_b.resize(static_cast<std::size_t>(a));
        scores_a.resize(static_cast<std::size_t>(a));
        scores_b.resize(static_cast<std::size_t>(a));
        EXPECT_EQ(columns_a, columns_b);
        EXPECT_EQ(scores_a, scores_b);
      }
    }
  }
}

TEST_P(VoKernels, SumTheReferencesAbsoluteDifferences) {
  std::mt19937 rng(8);
  const Kernels& reference = *kernels_for(Isa::reference);
  const Kernels& kernel = *kernels_for(GetParam());
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

INSTANTIATE_TEST_SUITE_P(All, VoKernels, testing::ValuesIn([] {
                           std::vector<Isa> there;
                           for (const Isa isa : {Isa::reference, Isa::sse4, Isa::avx2, Isa::neon}) {
                             if (kernels_for(isa) != nullptr) there.push_back(isa);
                           }
                           return there;
                         }()),
                         [](const auto& param) { return std::string(isa_name(param.param)); });

}  // namespace
}  // namespace cliquevo::vo
