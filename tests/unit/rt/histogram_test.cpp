// SPDX-License-Identifier: BSD-3-Clause
#include "core/rt/histogram.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace cliquevo::rt {
namespace {

TEST(Histogram, BucketsAreGaplessInOrderAndNarrowerThanOnePercent) {
  std::int64_t begin = 0;
  for (std::size_t i = 0; i < Histogram::kBuckets; ++i) {
    const std::int64_t end = Histogram::bucket_end_ns(i);
    ASSERT_GE(end, begin);
    ASSERT_EQ(Histogram::bucket_of(begin), i);
    ASSERT_EQ(Histogram::bucket_of(end), i);
    ASSERT_LE(static_cast<double>(end - begin), 0.01 * static_cast<double>(begin) + 0.5);
    begin = end + 1;
  }
  EXPECT_EQ(begin - 1, Histogram::kLargestNs);
}

TEST(Histogram, PercentilesLieWithinOnePercentAboveTheExactOnes) {
  std::mt19937_64 rng(7);
  std::lognormal_distribution<double> spread(15.0, 2.0);
  Histogram histogram;
  std::vector<std::int64_t> values;
  for (int i = 0; i < 20'000; ++i) {
    values.push_back(static_cast<std::int64_t>(std::min(spread(rng), 1e11)));
    histogram.record(values.back());
  }
  std::sort(values.begin(), values.end());
  const auto exact = [&](double fraction) {
    return values[static_cast<std::size_t>(std::ceil(fraction * static_cast<double>(values.size()))) - 1];
  };
  const Percentiles p = histogram.percentiles();
  EXPECT_EQ(p.count, values.size());
  const auto expect_near = [](std::int64_t found, std::int64_t wanted) {
    EXPECT_GE(found, wanted);
    EXPECT_LE(static_cast<double>(found), 1.01 * static_cast<double>(wanted));
  };
  expect_near(p.p50_ns, exact(0.5));
  expect_near(p.p90_ns, exact(0.9));
  expect_near(p.p99_ns, exact(0.99));
  expect_near(p.p999_ns, exact(0.999));
  expect_near(p.max_ns, values.back());
}

TEST(Histogram, ValuesOutOfRangeCountAtTheEnds) {
  Histogram histogram;
  histogram.record(-5);
  histogram.record(std::int64_t{1} << 60);
  EXPECT_EQ(histogram.total(), 2u);
  EXPECT_EQ(Histogram::percentile_of(histogram.counts(), 0.5), 0);
  EXPECT_EQ(histogram.percentiles().max_ns, Histogram::kLargestNs);
}

TEST(Histogram, AnEmptyOneHasZeroPercentiles) {
  const Histogram histogram;
  EXPECT_EQ(histogram.percentiles().count, 0u);
  EXPECT_EQ(histogram.percentiles().p999_ns, 0);
}

TEST(Histogram, TheDifferenceOfTwoCountsIsTheTimeBetween) {
  Histogram histogram;
  histogram.record(1'000'000);
  const auto before = histogram.counts();
  histogram.record(50);
  histogram.record(60);
  const Percentiles p = Histogram::percentiles_of(Histogram::difference(histogram.counts(), before));
  EXPECT_EQ(p.count, 2u);
  EXPECT_EQ(p.p50_ns, 50);
  EXPECT_EQ(p.max_ns, 60);
}

}  // namespace
}  // namespace cliquevo::rt
