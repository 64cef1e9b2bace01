// SPDX-License-Identifier: BSD-3-Clause
#include "tools/camera_run.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace cliquevo::tools {

namespace {

constexpr double kMostRateError = 0.05;
constexpr double kMostSkew = 0.25;                                           // periods
constexpr double kMostSkipped = 0.01;                                        // share of the exposures
constexpr std::array<double, 6> kEdges{0.001, 0.003, 0.01, 0.03, 0.1, 0.3};  // periods

std::string histogram(const char* name, const std::vector<double>& values, double period_ms) {
  std::array<std::int64_t, kEdges.size() + 1> counts{};
  for (const double value : values) {
    ++counts[static_cast<std::size_t>(std::upper_bound(kEdges.begin(), kEdges.end(), value) - kEdges.begin())];
  }
  std::string out = fmt::format("  {}\n", name);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const std::string upto = i < kEdges.size() ? fmt::format("< {:8.3f} ms", kEdges[i] * period_ms) : "      more   ";
    const auto share = values.empty() ? 0 : 40 * counts[i] / static_cast<std::int64_t>(values.size());
    out += fmt::format("    {}  {:6d}  {}\n", upto, counts[i], std::string(static_cast<std::size_t>(share), '#'));
  }
  return out;
}

}  // namespace

void CameraRun::add(TimestampNs stamp_ns, std::int64_t right_offset_ns, std::int64_t delay_ns) {
  stamps_ns_.push_back(stamp_ns);
  skews_.push_back(std::abs(static_cast<double>(right_offset_ns)) / period_ns_);
  delays_ms_.push_back(static_cast<double>(delay_ns) * 1e-6);
}

CameraRun::Verdict CameraRun::judge() const {
  Verdict out;
  if (pairs() < 2) {
    out.complaints.push_back(fmt::format("{} pairs came", pairs()));
    return out;
  }
  std::int64_t steps = 0;
  for (std::size_t i = 1; i < stamps_ns_.size(); ++i) {
    const double dt = static_cast<double>(stamps_ns_[i] - stamps_ns_[i - 1]) / period_ns_;
    const auto step = std::max<std::int64_t>(1, std::llround(dt));
    steps += step;
    out.skipped += step - 1;
    out.most_jitter = std::max(out.most_jitter, std::abs(dt - static_cast<double>(step)));
  }
  const double span_s = static_cast<double>(stamps_ns_.back() - stamps_ns_.front()) * 1e-9;
  const double nominal_hz = 1e9 / period_ns_;
  out.rate_hz = span_s > 0.0 ? static_cast<double>(steps) / span_s : 0.0;
  out.most_skew = *std::max_element(skews_.begin(), skews_.end());
  out.most_delay_ms = *std::max_element(delays_ms_.begin(), delays_ms_.end());
  if (!(std::abs(out.rate_hz - nominal_hz) <= kMostRateError * nominal_hz)) {
    out.complaints.push_back(fmt::format("rate {:.3f} Hz instead of {:.3f}", out.rate_hz, nominal_hz));
  }
  if (static_cast<double>(out.skipped) > kMostSkipped * static_cast<double>(steps)) {
    out.complaints.push_back(fmt::format("{} of {} exposures gave no pair", out.skipped, steps));
  }
  if (out.most_skew > kMostSkew) {
    out.complaints.push_back(fmt::format("cameras up to {:.2f} periods apart", out.most_skew));
  }
  return out;
}

std::string CameraRun::histograms() const {
  std::vector<double> jitters;
  for (std::size_t i = 1; i < stamps_ns_.size(); ++i) {
    const double dt = static_cast<double>(stamps_ns_[i] - stamps_ns_[i - 1]) / period_ns_;
    jitters.push_back(std::abs(dt - std::max(1.0, std::round(dt))));
  }
  return histogram("|dt - period|", jitters, period_ns_ * 1e-6) +
         histogram("right camera - left camera", skews_, period_ns_ * 1e-6);
}

}  // namespace cliquevo::tools
