// SPDX-License-Identifier: BSD-3-Clause
#include "core/rt/histogram.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

namespace cliquevo::rt {

// Values below 2^kSubBits have a bucket each; above, an octave [2^k, 2^(k+1)) is cut into 2^kSubBits equal buckets.
std::size_t Histogram::bucket_of(std::int64_t value_ns) {
  const auto v = static_cast<std::uint64_t>(std::clamp<std::int64_t>(value_ns, 0, kLargestNs));
  if (v < (std::uint64_t{1} << kSubBits)) return v;
  const int octave = static_cast<int>(std::bit_width(v)) - 1;
  const int shift = octave - kSubBits;
  const std::uint64_t within = (v >> shift) - (std::uint64_t{1} << kSubBits);
  return (static_cast<std::size_t>(shift + 1) << kSubBits) + within;
}

std::int64_t Histogram::bucket_end_ns(std::size_t bucket) {
  constexpr std::size_t kPerOctave = std::size_t{1} << kSubBits;
  if (bucket < kPerOctave) return static_cast<std::int64_t>(bucket);
  const auto shift = static_cast<int>(bucket >> kSubBits) - 1;
  const std::uint64_t first = (kPerOctave + bucket % kPerOctave) << shift;
  return static_cast<std::int64_t>(first + (std::uint64_t{1} << shift) - 1);
}

void Histogram::record(std::int64_t value_ns) {
  std::atomic<std::uint64_t>& count = counts_[bucket_of(value_ns)];
  // One writer: no read-modify-write needed.
  count.store(count.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
}

Histogram::Counts Histogram::counts() const {
  Counts out(kBuckets);
  for (std::size_t i = 0; i < kBuckets; ++i) out[i] = counts_[i].load(std::memory_order_relaxed);
  return out;
}

std::uint64_t Histogram::total() const {
  std::uint64_t sum = 0;
  for (const auto& count : counts_) sum += count.load(std::memory_order_relaxed);
  return sum;
}

std::int64_t Histogram::percentile_of(const Counts& counts, double fraction) {
  const std::uint64_t total = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
  if (total == 0) return 0;
  const double wanted = std::ceil(std::clamp(fraction, 0.0, 1.0) * static_cast<double>(total));
  const auto rank = std::clamp<std::uint64_t>(static_cast<std::uint64_t>(wanted), 1, total);
  std::uint64_t seen = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    seen += counts[i];
    if (seen >= rank) return bucket_end_ns(i);
  }
  return kLargestNs;
}

Percentiles Histogram::percentiles_of(const Counts& counts) {
  Percentiles out;
  out.count = std::accumulate(counts.begin(), counts.end(), std::uint64_t{0});
  out.p50_ns = percentile_of(counts, 0.5);
  out.p90_ns = percentile_of(counts, 0.9);
  out.p99_ns = percentile_of(counts, 0.99);
  out.p999_ns = percentile_of(counts, 0.999);
  out.max_ns = percentile_of(counts, 1.0);
  return out;
}

Histogram::Counts Histogram::difference(const Counts& now, const Counts& before) {
  Counts out(now.size());
  for (std::size_t i = 0; i < now.size(); ++i) out[i] = now[i] - (i < before.size() ? before[i] : 0);
  return out;
}

}  // namespace cliquevo::rt
