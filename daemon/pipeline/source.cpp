// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/source.h"

#include <chrono>
#include <thread>
#include <utility>
#include <vector>

#include "core/base/saturating.h"
#include "daemon/pipeline/camera_families.h"
#include "drivers/camera_order_watch.h"
#include "drivers/recording.h"
#include "drivers/simulator.h"

namespace cliquevo::daemon {

namespace {

using drivers::FrameSource;
using drivers::SourceInfo;
using drivers::StereoPair;

class PingPong : public FrameSource {
 public:
  PingPong(std::unique_ptr<FrameSource> source, std::vector<StereoPair> frames)
      : source_(std::move(source)), frames_(std::move(frames)), info_(copy_of(source_->info())) {
    info_.description += ", forward and backward without end";
    info_.frame_count = -1;
  }

  const SourceInfo& info() const override { return info_; }

  Result<bool> next(StereoPair& pair) override {
    const StereoPair& frame = frames_[at_];
    if (played_ > 0) {
      stamp_ns_ = saturated_sum(stamp_ns_, saturated_distance(frame.stamp_ns, frames_[before_].stamp_ns));
    } else {
      stamp_ns_ = frame.stamp_ns;
    }
    pair.index = played_++;
    pair.stamp_ns = stamp_ns_;
    pair.left.copy_from(frame.left.view());
    pair.right.copy_from(frame.right.view());
    pair.truth_T_world_camera = frame.truth_T_world_camera;
    before_ = at_;
    if (at_ == 0) forward_ = true;
    if (at_ + 1 == frames_.size()) forward_ = false;
    at_ = forward_ ? at_ + 1 : at_ - 1;
    return true;
  }

 private:
  static SourceInfo copy_of(const SourceInfo& info) {
    SourceInfo out;
    out.description = info.description;
    out.width = info.width;
    out.height = info.height;
    out.rate_hz = info.rate_hz;
    out.calibration = info.calibration;
    out.T_body_camera = info.T_body_camera;
    if (!info.left_mask.empty()) out.left_mask.copy_from(info.left_mask.view());
    if (!info.right_mask.empty()) out.right_mask.copy_from(info.right_mask.view());
    return out;
  }

  std::unique_ptr<FrameSource> source_;
  std::vector<StereoPair> frames_;
  SourceInfo info_;
  std::size_t at_ = 0;
  std::size_t before_ = 0;
  bool forward_ = true;
  std::int64_t played_ = 0;
  TimestampNs stamp_ns_ = 0;
};

}  // namespace

std::string built_in_sources() {
  const std::string families = built_in_families();
  return "simulator, recording" + (families.empty() ? "" : ", " + families);
}

Result<std::unique_ptr<FrameSource>> make_pingpong(std::unique_ptr<FrameSource> source, std::size_t max_bytes) {
  std::vector<StereoPair> frames;
  std::size_t bytes = 0;
  for (;;) {
    StereoPair pair;
    const auto more = source->next(pair);
    if (!more) return more.error();
    if (!*more) break;
    bytes += 2 * static_cast<std::size_t>(pair.left.width()) * static_cast<std::size_t>(pair.left.height());
    if (bytes > max_bytes) {
      return Error{"recording too large to play forward and backward", source->info().description,
                   "play a part of it: set first and last"};
    }
    frames.push_back(std::move(pair));
  }
  if (frames.size() < 2) {
    return Error{"recording too short to play forward and backward", source->info().description,
                 "it needs two pairs at least"};
  }
  return std::unique_ptr<FrameSource>(std::make_unique<PingPong>(std::move(source), std::move(frames)));
}

Result<std::unique_ptr<FrameSource>> open_source(const SourceConfig& config) {
  drivers::OpenTrouble ignored = drivers::OpenTrouble::lasting;
  return open_source(config, ignored);
}

Result<std::unique_ptr<FrameSource>> open_source_within(const SourceConfig& config, double wait_s,
                                                        const std::function<bool()>& stopped) {
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::duration<double>(wait_s);
  for (;;) {
    drivers::OpenTrouble trouble = drivers::OpenTrouble::lasting;
    auto opened = open_source(config, trouble);
    if (opened || trouble == drivers::OpenTrouble::lasting) return opened;
    constexpr int kSteps = 10;
    for (int i = 0; i < kSteps; ++i) {
      if (stopped() || std::chrono::steady_clock::now() >= give_up) return opened;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
  }
}

namespace {

Result<std::unique_ptr<FrameSource>> open_family(const SourceConfig& config, drivers::OpenTrouble& trouble) {
  const bool pingpong = config.loop == "pingpong";
  if (config.type == "recording") {
    drivers::RecordingOptions options = config.recording;
    options.order_stated = config.swap_eyes;
    options.pingpong = pingpong;  // recordings can do so themselves, of any length
    return drivers::open_recording(options);
  }
  if (config.type == "simulator") {
    auto simulator = drivers::open_simulator(config.simulator);
    if (!simulator) return simulator.error();
    std::unique_ptr<FrameSource> source = std::move(*simulator);
    return pingpong ? make_pingpong(std::move(source)) : Result<std::unique_ptr<FrameSource>>(std::move(source));
  }
  for (const CameraFamily& family : camera_families()) {
    if (config.type == family.name && family.is_built_in()) return family.open(config.cameras, trouble);
  }
  return Error{"source is not in this build", "source.type = " + config.type,
               "build where its library is found (`cliquevod --version` lists what is in)"};
}

}  // namespace

Result<std::unique_ptr<FrameSource>> open_source(const SourceConfig& config, drivers::OpenTrouble& trouble) {
  trouble = drivers::OpenTrouble::lasting;
  auto source = open_family(config, trouble);
  const bool unwatched = config.type == "simulator" || (config.is_live() && !config.cameras.needs_calibration);
  if (!source || (unwatched && !config.swap_eyes)) return source;
  return drivers::watch_camera_order(std::move(*source), config.swap_eyes);
}

}  // namespace cliquevo::daemon
