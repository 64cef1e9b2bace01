// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/rectified_size.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <pthread.h>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/base/time.h"
#include "core/rt/thread.h"
#include "daemon/pipeline/stages.h"

namespace cliquevo::daemon {

namespace {

constexpr std::array kScales{1.0, 0.85, 0.75, 0.625, 0.5, 0.45, 0.4, 0.35, 0.3, 0.25, 0.2, 0.15, 0.1};
constexpr double kCheapPixels = 500'000.0;  // measured first: a few milliseconds a frame
constexpr double kWorthMeasuring = 1.15;    // an estimate above the budget by this may still turn out to fit
// Of a frame's period. The rest is for taking and sending frames, for hiccups and for what else runs.
constexpr double kBudgetShare = 0.7;
constexpr int kWarmUp = 1;
constexpr int kFrames = 5;
constexpr double kClearly = 0.5;  // of the budget: one frame of the native size is enough to know

double relative_pixels(double scale) { return scale * scale; }

// ---- made-up pairs: a wall with texture of several sizes, which moves a little from frame to frame

std::uint32_t hash(std::uint32_t x, std::uint32_t y) {
  std::uint32_t h = x * 0x9e3779b1U ^ y * 0x85ebca77U;
  h ^= h >> 15U;
  h *= 0x2c1b3c6dU;
  h ^= h >> 12U;
  return h;
}

Image<std::uint8_t> make_texture(int width, int height) {
  constexpr std::array<unsigned, 3> kCellBits{2, 4, 6};
  Image<std::uint8_t> out(width, height);
  const ImageView<std::uint8_t> view = out.view();
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      std::uint32_t sum = 0;
      for (const unsigned bits : kCellBits) {
        sum += hash(static_cast<std::uint32_t>(x) >> bits, (static_cast<std::uint32_t>(y) >> bits) + bits) & 0x3fU;
      }
      view(x, y) =
          static_cast<std::uint8_t>(sum + (hash(static_cast<std::uint32_t>(x), static_cast<std::uint32_t>(y)) & 7U));
    }
  }
  return out;
}

class MadeUpPairs {
 public:
  MadeUpPairs(int width, int height) : width_(width), height_(height) {
    disparity_ = std::clamp(width / 40, 2, 60);
    step_ = std::max(1, width / 400);
    texture_ = make_texture(width + disparity_ + 2 * step_, height);
  }
  void fill(std::int64_t index, TimestampNs period_ns, drivers::StereoPair& pair) const {
    pair.index = index;
    pair.stamp_ns = (index + 1) * period_ns;
    const int at = static_cast<int>(index % 3) * step_;
    copy(at, pair.left);
    copy(at + disparity_, pair.right);
  }

 private:
  void copy(int left, Image<std::uint8_t>& to) const {
    const ImageView<const std::uint8_t> from = texture_.cview();
    to.copy_from({from.data + std::min(left, from.width - width_), width_, height_, from.stride});
  }
  int width_;
  int height_;
  int disparity_ = 0;
  int step_ = 0;
  Image<std::uint8_t> texture_;
};

void schedule_workers(const RealtimeConfig& config, StereoStage& stereo) {
  for (const auto handle : stereo.worker_handles()) {
    rt::schedule(handle, {.name = "vo-measure-2", .fifo_priority = config.stereo_priority});
  }
}

// What keeps up at best: both stages run beside each other, on as many cores as there are.
double frame_cost_ms(std::int64_t stereo_ns, std::int64_t odometry_ns, int workers) {
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  const double stereo = static_cast<double>(stereo_ns) * 1e-6;
  const double odometry = static_cast<double>(odometry_ns) * 1e-6;
  const double shared = (std::min(workers, cores) * stereo + odometry) / cores;
  return std::max({stereo, odometry, shared});
}

Result<double> measure(const Config& config, const drivers::SourceInfo& source, const MadeUpPairs& pairs, double scale,
                       double period_ms) {
  stereo::RectifyParams rectify = config.rectify;
  rectify.scale = scale;
  auto stereo = StereoStage::make(config.stereo, source, rectify);
  if (!stereo) return stereo.error();
  auto odometry = OdometryStage::make(config.odometry, source, *stereo);
  if (!odometry) return odometry.error();
  schedule_workers(config.realtime, *stereo);
  StereoFrame frame;
  stereo->prepare(frame);
  drivers::StereoPair pair;
  const auto period_ns = static_cast<TimestampNs>(period_ms * 1e6);
  std::int64_t best_stereo_ns = 0;
  std::int64_t best_odometry_ns = 0;
  for (int i = 0; i < kWarmUp + kFrames; ++i) {
    pairs.fill(i, period_ns, pair);
    const std::int64_t begin_ns = monotonic_ns();
    if (auto ok = stereo->run(pair, frame); !ok) return ok.error();
    const std::int64_t middle_ns = monotonic_ns();
    if (auto ok = odometry->run(pair.stamp_ns, frame); !ok) return ok.error();
    const std::int64_t end_ns = monotonic_ns();
    if (i < kWarmUp) continue;  // the least of each: whatever else runs takes away, never gives
    const bool first = i == kWarmUp;
    best_stereo_ns = first ? middle_ns - begin_ns : std::min(best_stereo_ns, middle_ns - begin_ns);
    best_odometry_ns = first ? end_ns - middle_ns : std::min(best_odometry_ns, end_ns - middle_ns);
    const double cost_ms = frame_cost_ms(best_stereo_ns, best_odometry_ns, config.stereo.workers);
    if (scale == 1.0 && cost_ms < kClearly * kBudgetShare * period_ms) break;
  }
  return frame_cost_ms(best_stereo_ns, best_odometry_ns, config.stereo.workers);
}

}  // namespace

Result<RectifiedSize> pick_scale(std::int64_t native_pixels, double budget_ms,
                                 const std::function<Result<double>(double scale)>& cost_ms) {
  RectifiedSize out;
  out.measured = true;
  out.budget_ms = budget_ms;
  const auto take = [&out](std::size_t i, double cost) {
    out.scale = kScales[i];
    out.cost_ms = cost;
    out.native_cost_ms = cost / relative_pixels(kScales[i]);
  };
  std::size_t i = 0;
  while (i + 1 < kScales.size() && static_cast<double>(native_pixels) * relative_pixels(kScales[i]) > kCheapPixels) ++i;
  auto cost = cost_ms(kScales[i]);
  while (cost && *cost > budget_ms && i + 1 < kScales.size()) cost = cost_ms(kScales[++i]);
  if (!cost) return cost.error();
  take(i, *cost);
  out.fits = *cost <= budget_ms;
  if (!out.fits) return out;
  const double per_pixel = *cost / relative_pixels(kScales[i]);
  for (std::size_t larger = 0; larger < i; ++larger) {
    if (per_pixel * relative_pixels(kScales[larger]) > kWorthMeasuring * budget_ms) continue;
    const auto trial = cost_ms(kScales[larger]);
    if (!trial) return trial.error();
    if (larger == 0) out.native_cost_ms = *trial;
    if (*trial > budget_ms) continue;
    const double native_cost_ms = out.native_cost_ms;
    take(larger, *trial);
    out.native_cost_ms = std::max(native_cost_ms, *trial);
    break;
  }
  return out;
}

Result<RectifiedSize> choose_rectified_size(const Config& config, const drivers::SourceInfo& source) {
  RectifiedSize given;
  given.scale = config.rectify.scale.value_or(1.0);
  const bool waits = !source.live && config.source.speed <= 0.0;
  if (config.rectify.scale || waits || source.rate_hz <= 0.0) return given;
  // What is played faster than it was taken is not worth a coarser image.
  const double rate_hz = source.live ? source.rate_hz : source.rate_hz * std::min(1.0, config.source.speed);
  const double period_ms = 1e3 / rate_hz;
  const MadeUpPairs pairs(source.width, source.height);
  std::optional<Result<RectifiedSize>> picked;
  auto thread = rt::Thread::start({.name = "vo-measure", .fifo_priority = config.realtime.stereo_priority}, [&] {
    picked = pick_scale(std::int64_t{source.width} * source.height, kBudgetShare * period_ms,
                        [&](double scale) { return measure(config, source, pairs, scale, period_ms); });
  });
  if (!thread) return thread.error();
  thread->join();
  return picked ? std::move(*picked) : Result<RectifiedSize>(given);
}

std::string describe(const RectifiedSize& size, const drivers::SourceInfo& source) {
  if (!size.measured) return "";
  const auto dimensions = [&source](double scale) {
    return fmt::format("{}x{}", std::lround(source.width * scale), std::lround(source.height * scale));
  };
  const double period_ms = size.budget_ms / kBudgetShare;
  if (size.scale == 1.0 && size.fits) {
    return fmt::format(
        "rectified images keep their native size {} (rectify.scale auto): a frame takes {:.1f} ms of {:.1f} ms",
        dimensions(1.0), size.cost_ms, period_ms);
  }
  return fmt::format(
      "rectified images of {} (rectify.scale auto chose {:g}): a frame takes {:.1f} ms of {:.1f} ms, {:.1f} ms "
      "in the native size {}{}",
      dimensions(size.scale), size.scale, size.cost_ms, period_ms, size.native_cost_ms, dimensions(1.0),
      size.fits ? "" : "; this machine does not keep the rate: lower rate_hz or stereo.num_disparities");
}

}  // namespace cliquevo::daemon
