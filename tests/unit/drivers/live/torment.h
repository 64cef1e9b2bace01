// SPDX-License-Identifier: BSD-3-Clause
// Two cameras that behave as badly as cameras do, with the truth known.
#pragma once

#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

#include "drivers/live/pair_sync.h"

namespace cliquevo::test {

struct TormentOptions {
  std::uint64_t seed = 1;
  std::int64_t exposures = 10000;
  double rate_hz = 30.0;
  double arrival_jitter = 0.4;  // +- periods, even
  double stamp_jitter = 0.1;    // +- periods, even
  double drop = 0.02;           // share of frames, of each camera
  double twice = 0.01;
  double reorder = 0.01;  // arrives one to two periods late
  double drift_ppm = 100.0;
  double offset_s = 12345.678;  // of the right clock
  std::int64_t step_every = 0;  // exposures between steps of one clock or the other; 0 = never
  double most_step_periods = 20.0;
  double phase = 0.0;         // of the right camera's exposures, periods
  double right_pace_ppm = 0;  // the right camera's own rate, where it is not triggered
};

struct TormentFrame {
  drivers::CameraSide camera = drivers::CameraSide::left;
  drivers::SyncFrame frame;      // token: the exposure's number
  std::int64_t exposure_ns = 0;  // truth
  bool after_step = false;       // the first of this camera after a step of its clock
};

// All frames in order of arrival.
inline std::vector<TormentFrame> make_torment(const TormentOptions& o) {
  std::mt19937_64 random(o.seed);
  const auto even = [&](double from, double to) {
    return from + (to - from) * static_cast<double>(random() >> 11U) * 0x1p-53;
  };
  const double period_ns = 1e9 / o.rate_hz;
  double offset_ns[2] = {0.0, o.offset_s * 1e9};
  bool stepped[2] = {false, false};
  std::vector<TormentFrame> frames;
  for (std::int64_t k = 0; k < o.exposures; ++k) {
    if (o.step_every > 0 && k > 0 && k % o.step_every == 0) {
      const std::size_t camera = random() % 2;
      double step = 0.0;  // no whole number of periods
      while (std::abs(step - std::round(step)) < 0.02) step = even(-o.most_step_periods, o.most_step_periods);
      offset_ns[camera] += step * period_ns;
      stepped[camera] = true;
    }
    for (const std::size_t camera : {std::size_t{0}, std::size_t{1}}) {
      const double pace = camera == 1 ? 1.0 + o.right_pace_ppm * 1e-6 : 1.0;
      const double t_ns = (static_cast<double>(k) * pace + (camera == 1 ? o.phase : 0.0)) * period_ns;
      TormentFrame f;
      f.camera = camera == 0 ? drivers::CameraSide::left : drivers::CameraSide::right;
      f.exposure_ns = std::llround(t_ns);
      const double drift = camera == 1 ? t_ns * o.drift_ppm * 1e-6 : 0.0;
      const double jitter_ns = even(-o.stamp_jitter, o.stamp_jitter) * period_ns;
      f.frame.stamp_ns = std::llround(t_ns + drift + offset_ns[camera] + jitter_ns);
      double arrival_ns = t_ns + (0.7 + even(-o.arrival_jitter, o.arrival_jitter)) * period_ns;
      if (even(0, 1) < o.reorder) arrival_ns += even(1.0, 2.0) * period_ns;
      f.frame.arrival_ns = 1'000'000'000 + std::llround(arrival_ns);
      f.frame.token = static_cast<std::uint32_t>(k);
      if (even(0, 1) < o.drop) continue;
      f.after_step = stepped[camera];
      stepped[camera] = false;
      frames.push_back(f);
      if (even(0, 1) < o.twice) {
        f.frame.arrival_ns += std::llround(even(0.0, 0.5) * period_ns);
        f.after_step = false;
        frames.push_back(f);
      }
    }
  }
  std::stable_sort(frames.begin(), frames.end(), [](const TormentFrame& a, const TormentFrame& b) {
    return a.frame.arrival_ns < b.frame.arrival_ns;
  });
  return frames;
}

}  // namespace cliquevo::test
