// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/threads/grabber.h"

#include "core/base/caught.h"
#include "core/base/clock.h"
#include "daemon/pipeline/pacer.h"

namespace cliquevo::daemon {

namespace {

constexpr std::int64_t kRetryNs = 100'000'000;  // pause after a live source's error

}  // namespace

Grabber::Grabbed Grabber::grab_into(int index) {
  PipelineState& s = state_;
  const Result<bool> more = guarded("vo-grab", [&] { return s.source->next(s.slots[index].pair); });
  if (more.ok()) return *more ? Grabbed::pair : Grabbed::end;
  s.slots.release(index);
  s.source_errors.fetch_add(1, std::memory_order_relaxed);
  if (s.options.errors_are_final) {
    s.fail(more.error());
  } else if (s.live) {
    s.sleep_until(monotonic_ns() + kRetryNs);
  }  // a recording goes on behind the pair that it cannot deliver
  return Grabbed::none;
}

void Grabber::hand_on(int index) {
  PipelineState& s = state_;
  FrameSlot& slot = s.slots[index];
  slot.frame.times = {};
  slot.stamps = {};
  slot.stamps.grabbed_ns = utc_now_ns();
  slot.grabbed_mono_ns = monotonic_ns();
  s.grabbed.fetch_add(1, std::memory_order_relaxed);
  s.progress(StageId::stereo).entered();
  s.to_stereo.put(index, [&s](int skipped) {
    s.slots.release(skipped);
    s.progress(StageId::stereo).skipped();
    s.dropped_before_stereo.fetch_add(1, std::memory_order_relaxed);
  });
}

void Grabber::run() {
  PipelineState& s = state_;
  Pacer pacer(s.lossless() ? 1.0 : s.options.speed);
  while (!s.stopping()) {
    const int index = s.slots.acquire();
    if (index == PipelineState::kNone) {  // cannot be: there are enough slots for all threads
      s.sleep_until(monotonic_ns() + PipelineState::kPollNs);
      continue;
    }
    const Grabbed grabbed = grab_into(index);
    if (grabbed == Grabbed::none) continue;
    if (grabbed == Grabbed::end) break;
    const std::int64_t now_ns = monotonic_ns();
    if (s.lossless()) {
      while (!s.to_stereo.wait_until_taken(PipelineState::kPollNs) && !s.stopping()) {
      }
    } else if (!s.live) {
      s.sleep_until(pacer.due_ns(s.slots[index].pair.stamp_ns, now_ns));
    }
    if (s.stopping()) break;
    hand_on(index);
  }
}

}  // namespace cliquevo::daemon
