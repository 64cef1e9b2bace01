// SPDX-License-Identifier: BSD-3-Clause
// Log-linear histogram of durations, as HdrHistogram has them: every value within 1 %, from 1 ns to 2 minutes, in 30
// kB.
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace cliquevo::rt {

struct Percentiles {
  std::uint64_t count = 0;
  std::int64_t p50_ns = 0;
  std::int64_t p90_ns = 0;
  std::int64_t p99_ns = 0;
  std::int64_t p999_ns = 0;
  std::int64_t max_ns = 0;
};

class Histogram {
 public:
  static constexpr int kSubBits = 7;  // 128 buckets an octave: 1/128 < 1 %
  static constexpr std::int64_t kLargestNs = (std::int64_t{1} << 37) - 1;
  static constexpr std::size_t kBuckets = std::size_t{37 - kSubBits + 1} << kSubBits;

  // Counts at one moment. Differences of two are the counts of the time between.
  using Counts = std::vector<std::uint64_t>;

  // One thread; below 0 counts as 0, above kLargestNs as that. No allocation, no lock.
  void record(std::int64_t value_ns);
  // Any thread.
  Counts counts() const;
  std::uint64_t total() const;
  Percentiles percentiles() const { return percentiles_of(counts()); }

  static Percentiles percentiles_of(const Counts& counts);
  // The smallest bucket end that at least `fraction` of the values do not exceed; 0 without values.
  static std::int64_t percentile_of(const Counts& counts, double fraction);
  static Counts difference(const Counts& now, const Counts& before);

  // Which bucket a value falls into, and the largest value that falls into a bucket.
  static std::size_t bucket_of(std::int64_t value_ns);
  static std::int64_t bucket_end_ns(std::size_t bucket);

 private:
  std::array<std::atomic<std::uint64_t>, kBuckets> counts_{};
};

}  // namespace cliquevo::rt
