// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/threads/stage.h"

#include "core/base/caught.h"
#include "core/base/clock.h"

namespace cliquevo::daemon {

void Stage::run() {
  for (int index = input_.take(); index != PipelineState::kNone; index = input_.take()) process(index);
}

void Stage::process(int index) {
  FrameSlot& slot = state_.slots[index];
  begin(slot);
  const std::int64_t begin_ns = monotonic_ns();
  slot.stamps.*role_.begin = utc_now_ns();
  const Result<void> done = guarded(role_.name, [&] { return work(slot); });
  slot.stamps.*role_.end = utc_now_ns();
  state_.span(role_.span).record(monotonic_ns() - begin_ns);
  bool gone_on = false;
  if (done.ok()) {
    gone_on = hand_on(index);
  } else {
    state_.rejected.fetch_add(1, std::memory_order_relaxed);
    if (state_.options.errors_are_final) state_.fail(done.error());
  }
  if (!gone_on) state_.slots.give_back(role_.returns, index);
  state_.progress(role_.id).done();
}

StereoThread::StereoThread(PipelineState& state)
    : Stage(state, state.to_stereo,
            {StageId::stereo, Span::stereo, "vo-stereo", kFromStereo, &FrameStamps::stereo_begin_ns,
             &FrameStamps::stereo_end_ns}) {}

void StereoThread::begin(const FrameSlot& slot) {
  state_.span(Span::wake).record(monotonic_ns() - slot.grabbed_mono_ns);
}

Result<void> StereoThread::work(FrameSlot& slot) { return state_.work.stereo(slot); }

bool StereoThread::hand_on(int index) {
  PipelineState& s = state_;
  while (s.lossless() && !s.to_odometry.wait_until_taken(PipelineState::kPollNs) && !s.has_failed()) {
  }
  s.progress(StageId::odometry).entered();
  s.to_odometry.put(index, [&s](int skipped) {
    s.slots.give_back(kFromStereo, skipped);
    s.progress(StageId::odometry).skipped();
    s.dropped_before_odometry.fetch_add(1, std::memory_order_relaxed);
  });
  return true;
}

OdometryThread::OdometryThread(PipelineState& state)
    : Stage(state, state.to_odometry,
            {StageId::odometry, Span::odometry, "vo-odometry", kFromOdometry, &FrameStamps::odometry_begin_ns,
             &FrameStamps::odometry_end_ns}) {}

void OdometryThread::begin(const FrameSlot&) {
  if (!state_.reset_asked.exchange(false, std::memory_order_acq_rel)) return;
  state_.work.reset();
  state_.resets.fetch_add(1, std::memory_order_relaxed);
}

Result<void> OdometryThread::work(FrameSlot& slot) {
  out_ = {};
  try {
    return state_.work.odometry(slot, out_.frame);
  } catch (...) {
    state_.reset_asked.store(true, std::memory_order_release);  // half of a frame is in its memory
    throw;
  }
}

// The estimate goes to the output; the slot itself is free.
bool OdometryThread::hand_on(int index) {
  PipelineState& s = state_;
  const FrameSlot& slot = s.slots[index];
  out_.frame.index = slot.pair.index;
  out_.frame.times = slot.frame.times;
  out_.frame.stamps = slot.stamps;
  out_.frame.dropped = s.total_dropped();
  out_.frame.resets = s.resets.load(std::memory_order_relaxed);
  out_.grabbed_mono_ns = slot.grabbed_mono_ns;
  s.progress(StageId::output).entered();
  while (!s.outgoing.push(out_)) {
    if (s.lossless() &&
        !s.has_failed()) {  // nothing may be lost and nobody waits for this thread: let the output get on
      rt::Wakeup never;
      never.wait(never.state(), PipelineState::kPollNs);
      continue;
    }
    s.unsent.fetch_add(1, std::memory_order_relaxed);
    s.progress(StageId::output).skipped();
    break;
  }
  return false;
}

}  // namespace cliquevo::daemon
