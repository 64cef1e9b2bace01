// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/threads/pipeline.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <utility>

#include "core/base/caught.h"
#include "core/base/clock.h"
#include "core/rt/handover.h"
#include "core/rt/ring.h"
#include "core/rt/slot_pool.h"
#include "core/rt/wakeup.h"
#include "daemon/pipeline/pacer.h"

namespace cliquevo::daemon {

namespace {

constexpr int kNone = rt::Handover::kNone;
// One each in the grabber's, the stereo's and the odometry's hands and at least one between them; one to spare.
constexpr int slots_for(int backlog) { return 2 * backlog + 6; }
// Estimates that wait for the output: eight seconds at 30 Hz before one is lost.
constexpr std::size_t kOutgoing = 256;
constexpr std::int64_t kPollNs = 20'000'000;    // how often a wait looks whether it should stop
constexpr std::int64_t kRetryNs = 100'000'000;  // pause after a source's error
enum ReturningThread { kFromStereo, kFromOdometry, kReturningThreads };

// How a stage gets on, seen from outside. Work enters by the producer's hand and leaves by the consumer's, or by the
// producer's when it is skipped.
class Progress {
 public:
  void entered() {
    if (entered_.load(std::memory_order_relaxed) == left_.load(std::memory_order_relaxed)) touch();
    entered_.fetch_add(1, std::memory_order_relaxed);
  }
  void skipped() { left_.fetch_add(1, std::memory_order_relaxed); }
  void done() {
    touch();
    left_.fetch_add(1, std::memory_order_relaxed);
  }
  std::int64_t standing_still_ns() const {
    const std::int64_t left = left_.load(std::memory_order_relaxed);
    if (entered_.load(std::memory_order_relaxed) <= left) return 0;
    const std::int64_t still = monotonic_ns() - last_activity_ns_.load(std::memory_order_relaxed);
    return still > 0 ? still : 0;
  }

 private:
  void touch() { last_activity_ns_.store(monotonic_ns(), std::memory_order_relaxed); }
  std::atomic<std::int64_t> entered_{0};
  std::atomic<std::int64_t> left_{0};
  std::atomic<std::int64_t> last_activity_ns_{0};
};

// Slots are locked in memory: of large images fewer may wait than was asked for.
int backlog_within(int asked, const drivers::SourceInfo& info) {
  constexpr std::int64_t kMostBytes = std::int64_t{256} << 20;
  constexpr std::int64_t kBytesPerPixel = 7;  // raw and rectified pair, filtered image, disparity
  const std::int64_t slot = std::max<std::int64_t>(1, kBytesPerPixel * info.width * info.height);
  const std::int64_t most = (kMostBytes / slot - slots_for(0)) / (slots_for(1) - slots_for(0));
  return static_cast<int>(std::clamp<std::int64_t>(std::min<std::int64_t>(asked, most), 0, rt::Handover::kMostBacklog));
}

PipelineOptions for_source(PipelineOptions options, const drivers::FrameSource& source) {
  options.catch_up_frames = backlog_within(options.catch_up_frames, source.info());
  if (source.info().live) {
    options.speed = 1.0;
    options.errors_are_final = false;
  }
  return options;
}

struct Outgoing {
  PublishedFrame frame;
  std::int64_t grabbed_mono_ns = 0;
};

}  // namespace

const char* stage_name(Stage stage) {
  constexpr std::array<const char*, kStages> kNames{"stereo", "odometry", "output"};
  return kNames[static_cast<std::size_t>(stage)];
}

const char* span_name(Span span) {
  constexpr std::array<const char*, kSpans> kNames{"stereo", "odometry", "output", "wake", "total"};
  return kNames[static_cast<std::size_t>(span)];
}

struct Pipeline::Impl {
  Impl(const PipelineOptions& options_, PipelineWork work_, std::unique_ptr<drivers::FrameSource> source_)
      : options(for_source(options_, *source_)),
        work(std::move(work_)),
        source(std::move(source_)),
        live(source->info().live) {}

  // ---- the four threads; what a library throws at one of them ends the pipeline as an error
  void grab();
  void stereo();
  void odometry();
  void output();
  template <typename Body>
  void guard(const std::string& thread, const Body& body) {
    try {
      body();
    } catch (...) {
      fail(caught(thread));
    }
  }

  void grab_all();
  void stereo_all();
  void odometry_all();
  void output_all();

  bool lossless() const { return options.speed <= 0.0; }
  bool stopping() const { return stop_asked.load(std::memory_order_acquire); }
  bool has_failed() const { return failed.load(std::memory_order_acquire); }
  bool sleep_until(std::int64_t due_mono_ns);
  void send_on(FrameSlot& slot);
  void fail(const Error& what);
  void ask_stop() {
    stop_asked.store(true, std::memory_order_release);
    stop_wakeup.signal();
    source->interrupt();
  }
  Progress& progress(Stage stage) { return progresses[static_cast<std::size_t>(stage)]; }
  rt::Histogram& span(Span which) { return spans[static_cast<std::size_t>(which)]; }
  std::int64_t total_dropped() const {
    return dropped_before_stereo.load(std::memory_order_relaxed) +
           dropped_before_odometry.load(std::memory_order_relaxed);
  }

  PipelineOptions options;
  PipelineWork work;
  std::unique_ptr<drivers::FrameSource> source;
  bool live;

  int backlog = lossless() ? 0 : options.catch_up_frames;
  rt::SlotPool<FrameSlot> slots{slots_for(backlog), kReturningThreads};
  rt::Handover to_stereo{backlog};
  rt::Handover to_odometry{backlog};
  rt::Ring<Outgoing> outgoing{kOutgoing};
  rt::Wakeup stop_wakeup;
  std::atomic<bool> stop_asked{false};
  std::atomic<bool> reset_asked{false};

  std::atomic<std::int64_t> grabbed{0};
  std::atomic<std::int64_t> published{0};
  std::atomic<std::int64_t> dropped_before_stereo{0};
  std::atomic<std::int64_t> dropped_before_odometry{0};
  std::atomic<std::int64_t> rejected{0};
  std::atomic<std::int64_t> unsent{0};
  std::atomic<std::int64_t> source_errors{0};
  std::atomic<std::int32_t> resets{0};
  std::array<Progress, kStages> progresses;
  std::array<rt::Histogram, kSpans> spans;

  std::atomic<bool> failed{false};
  Error error;  // written once, by the thread that set `failed`; read once finished
  std::atomic<bool> finished{false};
  rt::Wakeup finished_wakeup;
  std::vector<std::string> shortfalls;
  std::array<rt::Thread, 4> threads;  // last: joined before anything they use goes
};

void Pipeline::Impl::fail(const Error& what) {
  if (!failed.exchange(true)) error = what;
  ask_stop();
}

// false: asked to stop.
bool Pipeline::Impl::sleep_until(std::int64_t due_mono_ns) {
  for (;;) {
    const std::uint32_t seen = stop_wakeup.state();
    if (stopping()) return false;
    const std::int64_t left_ns = due_mono_ns - monotonic_ns();
    if (left_ns <= 0) return true;
    stop_wakeup.wait(seen, left_ns);
  }
}

void Pipeline::Impl::grab() {
  guard("vo-grab", [this] { grab_all(); });
  to_stereo.close();
}

void Pipeline::Impl::grab_all() {
  Pacer pacer(lossless() ? 1.0 : options.speed);
  while (!stopping()) {
    const int index = slots.acquire();
    if (index == kNone) {  // cannot be: see slots_for()
      sleep_until(monotonic_ns() + kPollNs);
      continue;
    }
    FrameSlot& slot = slots[index];
    const Result<bool> more = guarded("vo-grab", [&] { return source->next(slot.pair); });
    if (!more.ok()) {
      slots.release(index);
      source_errors.fetch_add(1, std::memory_order_relaxed);
      if (options.errors_are_final) {
        fail(more.error());
      } else if (live) {
        sleep_until(monotonic_ns() + kRetryNs);
      }  // a recording goes on behind the pair that it cannot deliver
      continue;
    }
    if (!*more) break;
    const std::int64_t now_ns = monotonic_ns();
    if (lossless()) {
      while (!to_stereo.wait_until_taken(kPollNs) && !stopping()) {
      }
    } else if (!live) {
      sleep_until(pacer.due_ns(slot.pair.stamp_ns, now_ns));
    }
    if (stopping()) break;
    slot.frame.times = {};
    slot.stamps = {};
    slot.stamps.grabbed_ns = utc_now_ns();
    slot.grabbed_mono_ns = monotonic_ns();
    grabbed.fetch_add(1, std::memory_order_relaxed);
    progress(Stage::stereo).entered();
    to_stereo.put(index, [this](int skipped) {
      slots.release(skipped);
      progress(Stage::stereo).skipped();
      dropped_before_stereo.fetch_add(1, std::memory_order_relaxed);
    });
  }
}

void Pipeline::Impl::stereo() {
  guard(options.stereo.name, [this] { stereo_all(); });
  to_odometry.close();
}

void Pipeline::Impl::stereo_all() {
  for (int index = to_stereo.take(); index != kNone; index = to_stereo.take()) {
    FrameSlot& slot = slots[index];
    const std::int64_t begin_ns = monotonic_ns();
    span(Span::wake).record(begin_ns - slot.grabbed_mono_ns);
    slot.stamps.stereo_begin_ns = utc_now_ns();
    const Result<void> done = guarded("vo-stereo", [&] { return work.stereo(slot); });
    slot.stamps.stereo_end_ns = utc_now_ns();
    span(Span::stereo).record(monotonic_ns() - begin_ns);
    if (!done.ok()) {
      rejected.fetch_add(1, std::memory_order_relaxed);
      if (options.errors_are_final) fail(done.error());
      slots.give_back(kFromStereo, index);
      progress(Stage::stereo).done();
      continue;
    }
    while (lossless() && !to_odometry.wait_until_taken(kPollNs) && !has_failed()) {
    }
    progress(Stage::odometry).entered();
    to_odometry.put(index, [this](int skipped) {
      slots.give_back(kFromStereo, skipped);
      progress(Stage::odometry).skipped();
      dropped_before_odometry.fetch_add(1, std::memory_order_relaxed);
    });
    progress(Stage::stereo).done();
  }
}

void Pipeline::Impl::odometry() {
  guard(options.odometry.name, [this] { odometry_all(); });
  outgoing.close();
}

void Pipeline::Impl::odometry_all() {
  for (int index = to_odometry.take(); index != kNone; index = to_odometry.take()) {
    FrameSlot& slot = slots[index];
    if (reset_asked.exchange(false, std::memory_order_acq_rel)) {
      work.reset();
      resets.fetch_add(1, std::memory_order_relaxed);
    }
    const std::int64_t begin_ns = monotonic_ns();
    slot.stamps.odometry_begin_ns = utc_now_ns();
    bool thrown = true;
    const Result<void> done = guarded("vo-odometry", [&] {
      Result<void> processed = work.odometry(slot);
      thrown = false;
      return processed;
    });
    if (thrown) reset_asked.store(true, std::memory_order_release);  // half of a frame is in its memory
    slot.stamps.odometry_end_ns = utc_now_ns();
    span(Span::odometry).record(monotonic_ns() - begin_ns);
    if (done.ok()) {
      send_on(slot);
    } else {
      rejected.fetch_add(1, std::memory_order_relaxed);
      if (options.errors_are_final) fail(done.error());
    }
    slots.give_back(kFromOdometry, index);
    progress(Stage::odometry).done();
  }
}

void Pipeline::Impl::send_on(FrameSlot& slot) {
  Outgoing out;
  out.frame.index = slot.pair.index;
  out.frame.estimate = work.estimate();
  if (work.movers) out.frame.movers = work.movers();
  out.frame.times = slot.frame.times;
  out.frame.stamps = slot.stamps;
  out.frame.dropped = total_dropped();
  out.frame.resets = resets.load(std::memory_order_relaxed);
  out.grabbed_mono_ns = slot.grabbed_mono_ns;
  progress(Stage::output).entered();
  while (!outgoing.push(out)) {
    if (lossless() && !has_failed()) {  // nothing may be lost and nobody waits for this thread: let the output get on
      rt::Wakeup never;
      never.wait(never.state(), kPollNs);
      continue;
    }
    unsent.fetch_add(1, std::memory_order_relaxed);
    progress(Stage::output).skipped();
    return;
  }
}

void Pipeline::Impl::output() {
  guard(options.output.name, [this] { output_all(); });
  finished.store(true, std::memory_order_release);
  finished_wakeup.signal();
}

void Pipeline::Impl::output_all() {
  Outgoing out;
  while (outgoing.wait_pop(out)) {
    const std::int64_t begin_ns = monotonic_ns();
    const Result<void> done = guarded("vo-output", [&] { return work.output(out.frame), Result<void>(); });
    if (!done.ok()) {
      unsent.fetch_add(1, std::memory_order_relaxed);
      if (options.errors_are_final) fail(done.error());
    }
    const std::int64_t end_ns = monotonic_ns();
    span(Span::output).record(end_ns - begin_ns);
    span(Span::total).record(end_ns - out.grabbed_mono_ns);
    published.fetch_add(1, std::memory_order_relaxed);
    progress(Stage::output).done();
  }
}

Result<Pipeline> Pipeline::start(const PipelineOptions& options, PipelineWork work,
                                 std::unique_ptr<drivers::FrameSource> source) {
  auto impl = std::make_unique<Impl>(options, std::move(work), std::move(source));
  Impl* const self = impl.get();
  for (int i = 0; i < self->slots.size(); ++i) {
    FrameSlot& slot = self->slots[i];
    // The grabber's images too: a slot's first frame is not to be the one that allocates.
    const drivers::SourceInfo& info = self->source->info();
    slot.pair.left.resize(info.width, info.height);
    slot.pair.right.resize(info.width, info.height);
    slot.pair.left.fill(0);
    slot.pair.right.fill(0);
    self->work.prepare(slot);
  }

  // Consumers first: whoever is started finds the next one there.
  const std::array<std::pair<rt::ThreadOptions, void (Impl::*)()>, 4> roles{{
      {options.output, &Impl::output},
      {options.odometry, &Impl::odometry},
      {options.stereo, &Impl::stereo},
      {rt::ThreadOptions{.name = "vo-grab"}, &Impl::grab},
  }};
  for (std::size_t i = 0; i < roles.size(); ++i) {
    auto thread = rt::Thread::start(roles[i].first, [self, body = roles[i].second] { (self->*body)(); });
    if (!thread.ok()) {
      self->to_stereo.close();  // those that run already end, each with the one before it
      self->to_odometry.close();
      self->outgoing.close();
      return thread.error();
    }
    if (!thread->shortfall().empty()) {
      self->shortfalls.push_back(roles[i].first.name + ": " + thread->shortfall());
    }
    self->threads[i] = std::move(*thread);
  }
  return Pipeline(std::move(impl));
}

Pipeline::Pipeline(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Pipeline::Pipeline(Pipeline&&) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&& other) noexcept {
  if (impl_) impl_->ask_stop();  // its threads are joined as it goes
  impl_ = std::move(other.impl_);
  return *this;
}
Pipeline::~Pipeline() {
  if (impl_) impl_->ask_stop();
}

void Pipeline::stop() { impl_->ask_stop(); }

bool Pipeline::wait_finished(std::int64_t timeout_ns) {
  const std::uint32_t seen = impl_->finished_wakeup.state();
  if (impl_->finished.load(std::memory_order_acquire)) return true;
  impl_->finished_wakeup.wait(seen, timeout_ns);
  return impl_->finished.load(std::memory_order_acquire);
}

void Pipeline::request_reset() { impl_->reset_asked.store(true, std::memory_order_release); }

PipelineCounts Pipeline::counts() const {
  const Impl& m = *impl_;
  PipelineCounts out;
  out.grabbed = m.grabbed.load(std::memory_order_relaxed);
  out.published = m.published.load(std::memory_order_relaxed);
  out.dropped = m.total_dropped();
  out.rejected = m.rejected.load(std::memory_order_relaxed);
  out.unsent = m.unsent.load(std::memory_order_relaxed);
  out.source_errors = m.source_errors.load(std::memory_order_relaxed);
  out.resets = m.resets.load(std::memory_order_relaxed);
  return out;
}

Result<void> Pipeline::outcome() const {
  if (impl_->failed.load(std::memory_order_acquire)) return impl_->error;
  return {};
}

std::int64_t Pipeline::standing_still_ns(Stage stage) const { return impl_->progress(stage).standing_still_ns(); }

std::string Pipeline::source_status() const { return impl_->source->status(); }
std::string Pipeline::source_finding() const { return impl_->source->finding(); }

const rt::Histogram& Pipeline::histogram(Span span) const { return impl_->span(span); }

std::vector<std::string> Pipeline::shortfalls() const { return impl_->shortfalls; }

}  // namespace cliquevo::daemon
