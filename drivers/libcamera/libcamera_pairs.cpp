// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/libcamera/libcamera_pairs.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include <fmt/format.h>

#include "core/base/caught.h"

namespace cliquevo::drivers {

namespace {

constexpr std::int64_t kControlNs = 250'000'000;  // how often an exposure control of our own acts
constexpr auto kTick = std::chrono::milliseconds(50);
constexpr std::int64_t kFirstRetryNs = 200'000'000;
constexpr std::int64_t kLastRetryNs = 2'000'000'000;
constexpr std::int64_t kSilentNs = 3'000'000'000;

}  // namespace

Result<std::unique_ptr<LibcameraCamera>> LibcameraPairs::open_camera(CameraSide side, OpenTrouble& trouble) {
  const std::string& id = side == CameraSide::left ? options_.left : options_.right;
  return LibcameraCamera::open(
      id, options_, [this, side](const LibcameraFrame& frame) { hand_on(side, frame); }, trouble);
}

Result<std::unique_ptr<LibcameraPairs>> LibcameraPairs::open(const CameraOptions& options, OpenTrouble& trouble) {
  std::unique_ptr<LibcameraPairs> out(new LibcameraPairs(options));
  const std::size_t camera_count = options.layout == CameraLayout::two_cameras ? 2 : 1;
  for (std::size_t i = 0; i < camera_count; ++i) {
    auto camera = out->open_camera(i == 0 ? CameraSide::left : CameraSide::right, trouble);
    if (!camera) return camera.error();
    out->cameras_[i] = std::move(*camera);
  }
  const LibcameraCamera& left = *out->cameras_[0];
  if (camera_count == 2 && (left.width() != out->cameras_[1]->width() || left.height() != out->cameras_[1]->height())) {
    return Error{"cameras have unequal sizes", fmt::format("{} and {}", options.left, options.right),
                 fmt::format("they give {}x{} and {}x{}: set width and height", left.width(), left.height(),
                             out->cameras_[1]->width(), out->cameras_[1]->height())};
  }
  out->exposure_range_ = left.exposure_range();
  out->fourcc_ = left.fourcc();
  out->width_ = image_width(options.layout, left.fourcc(), left.width());
  out->height_ = left.height();
  PairSyncOptions sync;
  sync.rate_hz = options.rate_hz;
  sync.triggered = options.trigger != CameraTrigger::off;
  sync.shared_clock = true;  // the kernel's
  sync.stamped_on_arrival = true;
  out->pairs_ = std::make_unique<LivePairs>(sync, out->width_, out->height_);
  for (std::size_t i = 0; i < camera_count; ++i) {
    if (auto ok = out->cameras_[i]->start(); !ok) {
      trouble = out->cameras_[i]->trouble();
      return ok.error();
    }
  }
  out->watcher_ = std::thread([self = out.get()] {
    keep_going(
        "cameras' thread", self->stop_, [&] { self->watch(); }, [](const Error&) {});
  });
  return out;
}

LibcameraPairs::~LibcameraPairs() {
  stop_ = true;
  if (pairs_) pairs_->interrupt();
  if (watcher_.joinable()) watcher_.join();
  for (auto& camera : cameras_) camera.reset();
}

void LibcameraPairs::hand_on(CameraSide side, const LibcameraFrame& frame) {
  auto& [first, second] = grey_[static_cast<std::size_t>(side)];
  const Conversion converted = frame.whole ? to_grey(frame.raw, options_.layout, first, second) : Conversion{};
  if (!converted.whole) {
    pairs_->count_incomplete(side);
    return;
  }
  if (converted.flawed) pairs_->count_flawed(side);
  if (exposure_range_ && side == CameraSide::left) control_exposure(frame);
  const LiveFrame left{first.cview(), frame.stamp_utc_ns, frame.arrival_mono_ns, frame.arrival_utc_ns, frame.sequence};
  if (options_.layout == CameraLayout::two_cameras) {
    pairs_->push(side, left);
    return;
  }
  LiveFrame right = left;
  right.image = second.cview();
  pairs_->push_pair(left, right);
}

void LibcameraPairs::control_exposure(const LibcameraFrame& frame) {
  if (frame.arrival_mono_ns < next_control_ns_) return;
  next_control_ns_ = frame.arrival_mono_ns + kControlNs;
  if (frame.taken_with.exposure_us > 0.0) wanted_ = frame.taken_with;  // else it will be what was set last
  if (wanted_.exposure_us <= 0.0) wanted_.exposure_us = exposure_range_->most.exposure_us;
  wanted_ = next_exposure(grey_[0][0].cview(), wanted_, *exposure_range_);
  wanted_exposure_us_ = static_cast<std::int32_t>(wanted_.exposure_us);
  wanted_gain_ = static_cast<float>(wanted_.gain);
}

// One exposure and gain for both cameras: what our control sets, or what the left one's has found.
void LibcameraPairs::share_exposure() {
  if (options_.exposure_us || !cameras_[0]) return;
  LibcameraCamera* right = options_.layout == CameraLayout::two_cameras ? cameras_[1].get() : nullptr;
  if (exposure_range_ && wanted_exposure_us_ > 0) {
    cameras_[0]->follow(wanted_exposure_us_, wanted_gain_);
    if (right != nullptr) right->follow(wanted_exposure_us_, wanted_gain_);
  } else if (right != nullptr && cameras_[0]->exposure_us() > 0) {
    right->follow(cameras_[0]->exposure_us(), cameras_[0]->gain());
  }
}

// Looks after both cameras: opens again what is lost or silent, and has the right one follow the left one's exposure.
void LibcameraPairs::watch() {
  std::int64_t pause_ns[2] = {kFirstRetryNs, kFirstRetryNs};
  std::int64_t next_try_ns[2] = {0, 0};
  const std::size_t camera_count = options_.layout == CameraLayout::two_cameras ? 2 : 1;
  const std::int64_t patience_ns = std::max(kSilentNs, static_cast<std::int64_t>(5e9 / options_.rate_hz));
  while (!stop_) {
    std::this_thread::sleep_for(kTick);
    for (std::size_t i = 0; i < camera_count; ++i) {
      const CameraSide side = i == 0 ? CameraSide::left : CameraSide::right;
      const std::int64_t now_ns = monotonic_ns();
      if (cameras_[i]) {
        const bool silent = now_ns - cameras_[i]->last_frame_mono_ns() > patience_ns;
        if (!cameras_[i]->lost() && !silent) continue;
        pairs_->set_state(side, cameras_[i]->lost() ? "lost" : "silent");
        cameras_[i].reset();
        pause_ns[i] = kFirstRetryNs;
      }
      if (now_ns < next_try_ns[i]) continue;
      OpenTrouble ignored = OpenTrouble::lasting;  // whatever it is, it is tried again
      auto opened = open_camera(side, ignored);
      const bool fits = opened.ok() && (*opened)->height() == height_ && (*opened)->fourcc() == fourcc_ &&
                        image_width(options_.layout, fourcc_, (*opened)->width()) == width_;
      if (fits && (*opened)->start().ok()) {
        cameras_[i] = std::move(*opened);
        pairs_->set_state(side, "");
        continue;
      }
      pairs_->set_state(side, opened.ok() ? "reconnecting: it is back with another size or does not start"
                                          : "reconnecting: " + opened.error().what);
      next_try_ns[i] = now_ns + pause_ns[i];
      pause_ns[i] = std::min(2 * pause_ns[i], kLastRetryNs);
    }
    share_exposure();
  }
}

}  // namespace cliquevo::drivers
