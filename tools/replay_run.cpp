// SPDX-License-Identifier: BSD-3-Clause
#include "tools/replay_run.h"

#include <cerrno>
#include <cmath>
#include <ctime>

#include <fmt/format.h>

#include "tools/exit_code.h"
#include "tools/progress.h"
#include "tools/stop_on_signal.h"

namespace cliquevo::tools {

namespace {

// Holds frames back to `speed` times the pace of their stamps.
class Pace {
 public:
  explicit Pace(double speed) : speed_(speed) {}

  void wait_for(TimestampNs stamp_ns) {
    if (speed_ <= 0.0) return;
    if (!begun_) {
      begun_ = true;
      first_stamp_ns_ = stamp_ns;
      begin_ns_ = monotonic_ns();
    }
    const double since_first_ns = static_cast<double>(stamp_ns - first_stamp_ns_);
    const std::int64_t due_ns = begin_ns_ + std::llround(since_first_ns / speed_);
    const timespec due = {static_cast<time_t>(due_ns / 1'000'000'000), static_cast<long>(due_ns % 1'000'000'000)};
    while (!StopOnSignal::asked() && clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &due, nullptr) == EINTR) continue;
  }

 private:
  double speed_;
  bool begun_ = false;
  TimestampNs first_stamp_ns_ = 0;
  std::int64_t begin_ns_ = 0;
};

// What happens with a processed frame.
Result<void> hand_out(const FrameRecord& record, const vo::Movers& movers, ReplayOutputs& outputs, bool& warned) {
  if (outputs.publisher) {
    daemon::PublishedFrame frame;
    frame.index = record.index;
    frame.estimate = record.estimate;
    frame.times = record.times;
    frame.movers = movers;
    const bool sent = outputs.publisher->publish(frame);
    if (!sent && !warned) {
      warned = true;
      warn({"cannot send over LCM", fmt::format("frame {}", record.index), "the replay goes on; check the route"});
    }
  }
  if (outputs.trajectory) {
    return outputs.trajectory->append(record.estimate.stamp_ns, record.estimate.T_world_camera);
  }
  return {};
}

}  // namespace

ReplayEnd run_replay(drivers::FrameSource& source, daemon::FramePipeline& pipeline, ReplayOutputs& outputs,
                     RunLog& log) {
  const StopOnSignal signals;
  Progress progress(source.info().frame_count);
  Pace pace(outputs.speed);
  drivers::StereoPair pair;
  std::optional<RigidTransform> T_first_world;  // truth starts at the first frame played
  std::optional<Error> error;
  bool warned = false;
  const std::int64_t begin_ns = monotonic_ns();

  while (!error) {
    if (StopOnSignal::asked()) {
      error = Error{"interrupted", fmt::format("after {} frames", log.frames().size()),
                    "what was written holds the frames so far; run again for all of them"};
      break;
    }
    FrameRecord record;
    const std::int64_t read_begin_ns = monotonic_ns();
    const Result<bool> read = source.next(pair);
    record.read_ns = monotonic_ns() - read_begin_ns;
    if (!read) {
      error = read.error();
      break;
    }
    if (!*read) break;
    pace.wait_for(pair.stamp_ns);

    if (auto done = pipeline.process(pair); !done) {
      error = done.error();
      break;
    }
    record.index = pair.index;
    record.estimate = pipeline.estimate();
    record.times = pipeline.times();
    if (pair.truth_T_world_camera) {
      if (!T_first_world) T_first_world = pair.truth_T_world_camera->inverse();
      record.truth_T_world_camera = *T_first_world * *pair.truth_T_world_camera;
    }
    log.add(record);
    if (auto done = hand_out(record, pipeline.movers(), outputs, warned); !done) error = done.error();
    progress.update(static_cast<std::int64_t>(log.frames().size()), log.distance_m(),
                    vo::status_name(record.estimate.status));
  }
  progress.finish();
  return {error, static_cast<double>(monotonic_ns() - begin_ns) * 1e-9};
}

}  // namespace cliquevo::tools
