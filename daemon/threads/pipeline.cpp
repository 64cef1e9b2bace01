// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/threads/pipeline.h"

#include <array>
#include <utility>

#include "core/base/caught.h"
#include "core/rt/thread.h"
#include "daemon/threads/grabber.h"
#include "daemon/threads/pipeline_state.h"
#include "daemon/threads/stage.h"

namespace cliquevo::daemon {

struct Pipeline::Impl {
  Impl(const PipelineOptions& options, PipelineWork& work, std::unique_ptr<drivers::FrameSource> source)
      : state(options, work, std::move(source)), grabber(state), stereo_thread(state), odometry_thread(state) {}

  // What each thread does, up to letting the next one know that nothing follows.
  void grab() {
    guard("vo-grab", [this] { grabber.run(); });
    state.to_stereo.close();
  }
  void stereo() {
    guard(state.options.stereo.name, [this] { stereo_thread.run(); });
    state.to_odometry.close();
  }
  void odometry() {
    guard(state.options.odometry.name, [this] { odometry_thread.run(); });
    state.outgoing.close();
  }
  void output() {
    guard(state.options.output.name, [this] { output_all(); });
    state.finished.store(true, std::memory_order_release);
    state.finished_wakeup.signal();
  }
  void output_all();
  // What a library throws at a thread ends the pipeline as an error.
  template <typename Body>
  void guard(const std::string& thread, const Body& body) {
    try {
      body();
    } catch (...) {
      state.fail(caught(thread));
    }
  }
  void prepare_slots();
  Result<void> start_threads();

  PipelineState state;
  Grabber grabber;
  StereoThread stereo_thread;
  OdometryThread odometry_thread;
  std::vector<std::string> shortfalls;
  std::array<rt::Thread, 4> threads;  // last: joined before anything they use goes
};

void Pipeline::Impl::output_all() {
  Outgoing out;
  while (state.outgoing.wait_pop(out)) {
    const std::int64_t begin_ns = monotonic_ns();
    const Result<void> done = guarded("vo-output", [&] { return state.work.output(out.frame), Result<void>(); });
    if (!done.ok()) {
      state.unsent.fetch_add(1, std::memory_order_relaxed);
      if (state.options.errors_are_final) state.fail(done.error());
    }
    const std::int64_t end_ns = monotonic_ns();
    state.span(Span::output).record(end_ns - begin_ns);
    state.span(Span::total).record(end_ns - out.grabbed_mono_ns);
    state.published.fetch_add(1, std::memory_order_relaxed);
    state.progress(StageId::output).done();
  }
}

void Pipeline::Impl::prepare_slots() {
  const drivers::SourceInfo& info = state.source->info();
  for (int i = 0; i < state.slots.size(); ++i) {
    FrameSlot& slot = state.slots[i];
    // The grabber's images too: a slot's first frame is not to be the one that allocates.
    slot.pair.left.resize(info.width, info.height);
    slot.pair.right.resize(info.width, info.height);
    slot.pair.left.fill(0);
    slot.pair.right.fill(0);
    state.work.prepare(slot);
  }
}

Result<void> Pipeline::Impl::start_threads() {
  // Consumers first: whoever is started finds the next one there.
  const std::array<std::pair<rt::ThreadOptions, void (Impl::*)()>, 4> roles{{
      {state.options.output, &Impl::output},
      {state.options.odometry, &Impl::odometry},
      {state.options.stereo, &Impl::stereo},
      {rt::ThreadOptions{.name = "vo-grab"}, &Impl::grab},
  }};
  for (std::size_t i = 0; i < roles.size(); ++i) {
    auto thread = rt::Thread::start(roles[i].first, [this, body = roles[i].second] { (this->*body)(); });
    if (!thread.ok()) {
      state.to_stereo.close();  // those that run already end, each with the one before it
      state.to_odometry.close();
      state.outgoing.close();
      return thread.error();
    }
    if (!thread->shortfall().empty()) shortfalls.push_back(roles[i].first.name + ": " + thread->shortfall());
    threads[i] = std::move(*thread);
  }
  return {};
}

Result<Pipeline> Pipeline::start(const PipelineOptions& options, PipelineWork& work,
                                 std::unique_ptr<drivers::FrameSource> source) {
  auto impl = std::make_unique<Impl>(options, work, std::move(source));
  impl->prepare_slots();
  if (auto ok = impl->start_threads(); !ok) return ok.error();
  return Pipeline(std::move(impl));
}

Pipeline::Pipeline(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Pipeline::Pipeline(Pipeline&&) noexcept = default;
Pipeline& Pipeline::operator=(Pipeline&& other) noexcept {
  if (impl_) impl_->state.ask_stop();  // its threads are joined as it goes
  impl_ = std::move(other.impl_);
  return *this;
}
Pipeline::~Pipeline() {
  if (impl_) impl_->state.ask_stop();
}

void Pipeline::stop() { impl_->state.ask_stop(); }

bool Pipeline::wait_finished(std::int64_t timeout_ns) {
  PipelineState& state = impl_->state;
  const std::uint32_t seen = state.finished_wakeup.state();
  if (state.finished.load(std::memory_order_acquire)) return true;
  state.finished_wakeup.wait(seen, timeout_ns);
  return state.finished.load(std::memory_order_acquire);
}

void Pipeline::request_reset() { impl_->state.reset_asked.store(true, std::memory_order_release); }

PipelineCounts Pipeline::counts() const { return impl_->state.counts(); }

Result<void> Pipeline::outcome() const {
  if (impl_->state.has_failed()) return impl_->state.error;
  return {};
}

std::int64_t Pipeline::standing_still_ns(StageId stage) const {
  return impl_->state.progress(stage).standing_still_ns();
}

std::string Pipeline::source_status() const { return impl_->state.source->status(); }
std::string Pipeline::source_finding() const { return impl_->state.source->finding(); }

const rt::Histogram& Pipeline::histogram(Span span) const { return impl_->state.span(span); }

std::vector<std::string> Pipeline::shortfalls() const { return impl_->shortfalls; }

}  // namespace cliquevo::daemon
