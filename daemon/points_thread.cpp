// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/points_thread.h"

#include <atomic>
#include <cstdint>
#include <string>
#include <sys/resource.h>
#include <utility>
#include <vector>

#include "core/base/caught.h"
#include "core/rt/thread.h"
#include "core/rt/wakeup.h"
#include "daemon/lcm/image_tap.h"
#include "daemon/lcm/message_sender.h"
#include "daemon/lcm/points.h"

namespace cliquevo::daemon {

namespace {
constexpr int kNice = 10;  // behind what else runs without real-time priority
}  // namespace

struct PointsThread::Impl {
  enum class State { idle, working, done };  // who owns the images and the message: nobody, the thread, the output

  Impl(const LcmConfig& config, const StereoModel& stereo_model, const RigidTransform& camera)
      : channel(config.points_channel),
        step_px(config.points_step_px),
        model(stereo_model),
        T_body_camera(camera),
        tap({.width = stereo_model.width, .height = stereo_model.height, .rate_hz = config.points_rate_hz}) {}

  void run();
  bool make_message();

  const std::string channel;
  const int step_px;
  const StereoModel model;
  const RigidTransform T_body_camera;
  // None for a file, which takes one writer only: there the output thread writes.
  std::unique_ptr<MessageSender> sender;
  ImageTap tap;
  points_t message{};
  std::vector<std::uint8_t> bytes;
  std::size_t used = 0;  // of bytes
  bool sent = false;
  std::atomic<State> state{State::idle};
  std::atomic<bool> stopping{false};
  rt::Wakeup wakeup;
  rt::Thread thread;  // last: it uses the others
};

bool PointsThread::Impl::make_message() {
  used = 0;
  build_points(*tap.take(), model, T_body_camera, step_px, message);
  const int size = message.getEncodedSize();
  bytes.resize(static_cast<std::size_t>(size));
  if (message.encode(bytes.data(), 0, size) < 0) return false;
  used = bytes.size();
  return sender == nullptr || sender->send(channel, bytes.data(), used);
}

void PointsThread::Impl::run() {
  ::setpriority(PRIO_PROCESS, 0, kNice);  // on Linux: of the calling thread
  while (!stopping.load(std::memory_order_acquire)) {
    const std::uint32_t seen = wakeup.state();
    if (state.load(std::memory_order_acquire) == State::working) {
      sent = false;
      static_cast<void>(guarded("vo-points", [this]() -> Result<void> {
        sent = make_message();
        return {};
      }));
      state.store(State::done, std::memory_order_release);
    } else if (!stopping.load(std::memory_order_acquire)) {
      wakeup.wait(seen);
    }
  }
}

Result<std::unique_ptr<PointsThread>> PointsThread::start(const LcmConfig& config, const StereoModel& model,
                                                          const RigidTransform& T_body_camera) {
  if (config.points_channel.empty()) return std::unique_ptr<PointsThread>();
  auto impl = std::make_unique<Impl>(config, model, T_body_camera);
  if (!config.url.starts_with("file:")) {
    auto sender = MessageSender::open(config.url);
    if (!sender) return sender.error();
    impl->sender = std::move(*sender);
  }
  auto thread = rt::Thread::start({.name = "vo-points"}, [self = impl.get()] { self->run(); });
  if (!thread.ok()) return thread.error();
  impl->thread = std::move(*thread);
  return std::unique_ptr<PointsThread>(new PointsThread(std::move(impl)));
}

PointsThread::PointsThread(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

PointsThread::~PointsThread() {
  impl_->stopping.store(true, std::memory_order_release);
  impl_->wakeup.signal();
  impl_->thread.join();
}

void PointsThread::offer(TimestampNs stamp_ns, ImageView<const std::uint8_t> left,
                         ImageView<const std::int16_t> disparity) {
  impl_->tap.offer(stamp_ns, left, {}, disparity);
}

bool PointsThread::after_frame(Publisher& publisher) {
  Impl& m = *impl_;
  const Impl::State state = m.state.load(std::memory_order_acquire);
  if (state == Impl::State::working) return true;
  bool sent = true;
  if (state == Impl::State::done) {
    sent = m.sent && publisher.pass_on(m.channel, m.bytes.data(), m.used, m.sender == nullptr);
    m.state.store(Impl::State::idle, std::memory_order_relaxed);
    m.tap.give_back();
  } else if (m.tap.take() != nullptr) {
    m.state.store(Impl::State::working, std::memory_order_release);
    m.wakeup.signal();
  }
  return sent;
}

void PointsThread::set_rate(double rate_hz) { impl_->tap.set_rate(rate_hz); }

}  // namespace cliquevo::daemon
