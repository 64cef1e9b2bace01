// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/daemon_work.h"

#include <string>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "core/rt/thread.h"

namespace cliquevo::daemon {

void DaemonWork::prepare(FrameSlot& slot) { rig_.stereo.prepare(slot.frame); }

Result<void> DaemonWork::stereo(FrameSlot& slot) { return rig_.stereo.run(slot.pair, slot.frame); }

Result<void> DaemonWork::odometry(FrameSlot& slot, PublishedFrame& out) {
  auto done = rig_.odometry.run(slot.pair.stamp_ns, slot.frame);
  output_.tap.offer(slot.pair.stamp_ns, slot.frame.left.cview(), slot.frame.right.cview(),
                    slot.frame.disparity.cview());
  if (output_.points) {
    output_.points->offer(slot.pair.stamp_ns, slot.frame.left.cview(), slot.frame.disparity.cview());
  }
  if (done) output_.feature_tap.offer(rig_.odometry);
  out.estimate = rig_.odometry.estimate();
  if (with_movers_) out.movers = rig_.odometry.movers();
  return done;
}

void DaemonWork::reset() { rig_.odometry.reset(); }

void DaemonWork::output(const PublishedFrame& frame) { output_.take(frame); }

void schedule_workers(const RealtimeConfig& config, StereoStage& stereo) {
  int number = 1;
  for (const auto handle : stereo.worker_handles()) {
    const int cpu = config.worker_cpu >= 0 ? config.worker_cpu + number - 1 : -1;
    ++number;
    const std::string name = fmt::format("vo-stereo-{}", number);
    const std::string missing =
        rt::schedule(handle, {.name = name, .cpu = cpu, .fifo_priority = config.stereo_priority});
    if (!missing.empty()) spdlog::warn("without real-time rights: {}: {}", name, missing);
  }
}

}  // namespace cliquevo::daemon
