// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/live/exposure_control.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdlib>

namespace cliquevo::drivers {

namespace {

constexpr std::array kGammas = {1.0 / 1.9, 1.0 / 1.5, 1.0 / 1.2, 1.0, 1.2, 1.5, 1.9};
constexpr int kSamplesAcross = 96;  // of the picture, in either direction: enough for a sum, and a millisecond
// Of the paper: gradients below kQuiet are noise; above, they count by their logarithm.
constexpr double kQuiet = 0.06;
constexpr double kSteepness = 1000.0;
constexpr double kSpeed = 0.8;
constexpr double kCalm = 0.08;  // so near 1 nothing is changed: a change costs descriptors
constexpr double kGainSpan =
    4.0;  // a camera's gains are taken for so many doublings; what is wrong with that is seen next time

int step_of(int size) { return std::max(1, size / kSamplesAcross); }

double mean_of(ImageView<const std::uint8_t> image) {
  double sum = 0.0;
  double count = 0.0;
  for (int y = 0; y < image.height; y += step_of(image.height)) {
    for (int x = 0; x < image.width; x += step_of(image.width)) {
      sum += image.row(y)[x];
      count += 1.0;
    }
  }
  return count > 0.0 ? sum / count : 0.0;
}

// The sum of what each gradient counts when every value v is shown as v^gamma.
double gradients(ImageView<const std::uint8_t> image, double gamma) {
  std::array<float, 256> shown{};
  for (std::size_t v = 0; v < shown.size(); ++v) {
    shown[v] = static_cast<float>(std::pow(static_cast<double>(v) / 255.0, gamma));
  }
  double sum = 0.0;
  for (int y = 0; y + 1 < image.height; y += step_of(image.height)) {
    const std::uint8_t* row = image.row(y);
    const std::uint8_t* below = image.row(y + 1);
    for (int x = 0; x + 1 < image.width; x += step_of(image.width)) {
      const double here = shown[row[x]];
      const double across = shown[row[x + 1]] - here;
      const double down = shown[below[x]] - here;
      const double size = std::sqrt(across * across + down * down);
      if (size > kQuiet) sum += std::log(kSteepness * (size - kQuiet) + 1.0);
    }
  }
  return sum;
}

}  // namespace

double best_gamma(ImageView<const std::uint8_t> image) {
  std::array<double, kGammas.size()> seen{};
  for (std::size_t i = 0; i < kGammas.size(); ++i) seen[i] = gradients(image, kGammas[i]);
  const auto best = static_cast<std::size_t>(std::max_element(seen.begin(), seen.end()) - seen.begin());
  if (seen[best] <= 0.0) {
    const double mean = mean_of(image);
    return mean < 85.0 ? kGammas.front() : mean > 170.0 ? kGammas.back() : 1.0;
  }
  if (best == 0 || best + 1 == kGammas.size()) return kGammas[best];
  // Between the samples: the vertex of the parabola through the best and its neighbours, over the logarithm of gamma.
  const double bend = seen[best - 1] - 2.0 * seen[best] + seen[best + 1];
  const double offset = bend < 0.0 ? 0.5 * (seen[best - 1] - seen[best + 1]) / bend : 0.0;
  const double left = std::log(kGammas[best] / kGammas[best - 1]);
  const double right = std::log(kGammas[best + 1] / kGammas[best]);
  return kGammas[best] * std::exp(offset * (offset < 0.0 ? left : right));
}

ExposureSetting next_exposure(ImageView<const std::uint8_t> image, const ExposureSetting& now,
                              const ExposureRange& range) {
  ExposureSetting next{std::clamp(now.exposure_us, range.least.exposure_us, range.most.exposure_us),
                       std::clamp(now.gain, range.least.gain, range.most.gain)};
  const double gamma = best_gamma(image);
  if (std::abs(gamma - 1.0) < kCalm) return next;
  double factor = 1.0 + (gamma >= 1.0 ? 0.5 : 1.0) * kSpeed * (1.0 - gamma);
  const double span = range.most.gain - range.least.gain;
  const auto gain_takes = [&](double wanted) {
    if (span <= 0.0) return 1.0;
    const double before = next.gain;
    next.gain = std::clamp(before + span * std::log2(wanted) / kGainSpan, range.least.gain, range.most.gain);
    return std::exp2((next.gain - before) * kGainSpan / span);
  };
  if (factor < 1.0) factor /= gain_takes(factor);
  const double before_us = next.exposure_us;
  next.exposure_us = std::clamp(before_us * factor, range.least.exposure_us, range.most.exposure_us);
  if (factor > 1.0 && before_us > 0.0) gain_takes(factor * before_us / next.exposure_us);
  return next;
}

}  // namespace cliquevo::drivers
