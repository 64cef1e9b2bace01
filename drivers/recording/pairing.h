// SPDX-License-Identifier: BSD-3-Clause
// Which image of the left camera belongs to which of the right.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "drivers/recording/layout.h"

namespace cliquevo::drivers {

struct ImagePair {
  TimestampNs stamp_ns = 0;  // the left image's
  std::string left;          // paths
  std::string right;         // empty: it has none, and is not to be played
};

struct Pairing {
  std::vector<ImagePair> pairs;  // in the order in which they were recorded; stamps may step back or repeat
  std::int64_t unpaired = 0;     // images without a partner, both cameras together
};

// By name where both folders hold the same names, also where either lacks a few of the other's; else by time, each with
// its mutually nearest within the tolerance (default a quarter of the left camera's period). rate_hz gives the stamps,
// whatever times there are. Errors: no times and no rate, no pair at all, names that do not match and no times.
Result<Pairing> pair_images(const Layout& layout, std::optional<double> rate_hz,
                            std::optional<double> pair_tolerance_s);

// Of stamps that rise strictly: positions of each left one and its mutually nearest right one within the tolerance.
std::vector<std::pair<std::size_t, std::size_t>> nearest_pairs(const std::vector<TimestampNs>& left,
                                                               const std::vector<TimestampNs>& right,
                                                               std::int64_t tolerance_ns);
// The tolerance that was given, else a quarter of the stamps' period [ns].
std::int64_t pair_tolerance_ns(std::optional<double> given_s, const std::vector<TimestampNs>& stamps);

// The stamp of pair i at a steady rate.
TimestampNs stamp_at(std::size_t i, double rate_hz);

// Median of the differences; 0 for fewer than two.
std::int64_t median_period_ns(const std::vector<TimestampNs>& stamps);

}  // namespace cliquevo::drivers
