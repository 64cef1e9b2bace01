// SPDX-License-Identifier: BSD-3-Clause
#include "tools/replay_run.h"

#include <algorithm>

#include <fmt/format.h>

#include "daemon/pipeline/pacer.h"
#include "tools/exit_code.h"
#include "tools/progress.h"
#include "tools/stop_on_signal.h"

namespace cliquevo::tools {

namespace {

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

// Where the vehicle is thought to be meanwhile: a line a pair keeps trajectories with references.
Result<void> skip(const drivers::StereoPair& pair, const Error& why, ReplayOutputs& outputs, RunLog& log) {
  log.skip(pair.index, why);
  if (!outputs.trajectory) return {};
  const bool any = !log.frames().empty();
  const vo::Estimate last = any ? log.frames().back().estimate : vo::Estimate{};
  const bool stamped = outputs.trajectory->format() == daemon::TrajectoryFormat::tum;
  if (stamped && any && pair.stamp_ns <= last.stamp_ns) return {};
  return outputs.trajectory->append(pair.stamp_ns, last.T_world_camera);
}

}  // namespace

ReplayEnd run_replay(drivers::FrameSource& source, daemon::FramePipeline& pipeline, ReplayOutputs& outputs,
                     RunLog& log) {
  const StopOnSignal signals;
  Progress progress(source.info().frame_count);
  daemon::Pacer pacer(outputs.speed > 0.0 ? outputs.speed : 1.0);
  drivers::StereoPair pair;
  std::optional<RigidTransform> T_first_world;  // truth starts at the first frame played
  std::optional<Error> error;
  bool warned = false;
  const std::int64_t most_skipped = std::max<std::int64_t>(1000, source.info().frame_count);
  const std::int64_t begin_ns = monotonic_ns();

  while (!error) {
    if (StopOnSignal::received()) {
      error = Error{"interrupted", fmt::format("after {} frames", log.frames().size()),
                    "what was written holds the frames so far; run again for all of them"};
      break;
    }
    FrameRecord record;
    const std::int64_t read_begin_ns = monotonic_ns();
    const Result<bool> read = source.next(pair);
    record.read_ns = monotonic_ns() - read_begin_ns;
    if (!read) {
      if (outputs.strict) return {read.error(), true, static_cast<double>(monotonic_ns() - begin_ns) * 1e-9};
      if (auto done = skip(pair, read.error(), outputs, log); !done) error = done.error();
      // No source has more of them than pairs; one that does is stuck.
      if (log.skipped().count() > most_skipped) error = read.error();
      continue;
    }
    if (!*read) break;
    if (outputs.speed > 0.0) StopOnSignal::sleep_until(pacer.due_ns(pair.stamp_ns, monotonic_ns()));

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
    if (outputs.report) outputs.report->add(pipeline, pair);
    if (auto done = hand_out(record, pipeline.movers(), outputs, warned); !done) error = done.error();
    progress.update(static_cast<std::int64_t>(log.frames().size()), log.distance_m(),
                    vo::status_name(record.estimate.status));
  }
  progress.finish();
  return {error, false, static_cast<double>(monotonic_ns() - begin_ns) * 1e-9};
}

}  // namespace cliquevo::tools
