// SPDX-License-Identifier: BSD-3-Clause
#include "tools/bag_recorder.h"

#include <array>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <utility>

#include "core/base/caught.h"
#include "tools/ros2_bag.h"

namespace cliquevo::tools {

struct BagRecorder::Impl {
  explicit Impl(Ros2Bag out) : bag(std::move(out)) {}
  ~Impl() { end(); }

  void end() {
    {
      const std::lock_guard<std::mutex> lock(mutex);
      stopping = true;
    }
    changed.notify_all();
    if (thread.joinable()) thread.join();
  }

  void write_all() {
    for (std::size_t k = 0;; ++k) {
      drivers::StereoPair& pair = slots[k % slots.size()];
      {
        std::unique_lock<std::mutex> lock(mutex);
        changed.wait(lock, [this] { return filled > 0 || stopping; });
        if (filled == 0 || failure) return;
      }
      const Result<void> done = guarded("writing a bag", [&] { return bag.add(pair); });
      {
        const std::lock_guard<std::mutex> lock(mutex);
        --filled;
        if (done) {
          ++counts.pairs;
        } else {
          failure = done.error();
        }
        counts.bytes = bag.bytes();
      }
      changed.notify_all();
      if (!done) return;
    }
  }

  Ros2Bag bag;  // the thread's until it has ended
  bool wait_when_full = false;
  std::array<drivers::StereoPair, 16> slots;
  std::size_t added = 0;
  mutable std::mutex mutex;
  std::condition_variable changed;
  std::size_t filled = 0;
  bool stopping = false;
  drivers::RecorderCounts counts;
  std::optional<Error> failure;
  std::thread thread;
};

BagRecorder::BagRecorder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
BagRecorder::BagRecorder(BagRecorder&&) noexcept = default;
BagRecorder& BagRecorder::operator=(BagRecorder&&) noexcept = default;
BagRecorder::~BagRecorder() = default;

Result<BagRecorder> BagRecorder::start(const std::string& path, bool wait_when_full, const drivers::SourceInfo& info,
                                       const RigidTransform& T_body_camera) {
  auto bag = Ros2Bag::create(path, info, T_body_camera);
  if (!bag) return bag.error();
  auto impl = std::make_unique<Impl>(std::move(*bag));
  impl->wait_when_full = wait_when_full;
  impl->counts.files = 1;
  impl->thread = std::thread([m = impl.get()] { m->write_all(); });
  return BagRecorder(std::move(impl));
}

void BagRecorder::add(const drivers::StereoPair& pair) {
  Impl& m = *impl_;
  std::unique_lock<std::mutex> lock(m.mutex);
  if (m.wait_when_full) {
    m.changed.wait(lock, [&m] { return m.filled < m.slots.size() || m.failure; });
  }
  if (m.filled == m.slots.size() || m.failure) {
    ++m.counts.left_out;
    return;
  }
  drivers::StereoPair& slot = m.slots[m.added++ % m.slots.size()];
  lock.unlock();  // an empty slot is nobody else's
  slot.stamp_ns = pair.stamp_ns;
  slot.left.copy_from(pair.left.cview());
  slot.right.copy_from(pair.right.cview());
  lock.lock();
  ++m.filled;
  lock.unlock();
  m.changed.notify_all();
}

drivers::RecorderCounts BagRecorder::counts() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return impl_->counts;
}

std::optional<Error> BagRecorder::failure() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return impl_->failure;
}

Result<void> BagRecorder::stop() {
  impl_->end();
  if (impl_->failure) return *impl_->failure;
  Result<void> done = impl_->bag.finish();
  impl_->counts.bytes = impl_->bag.bytes();
  return done;
}

}  // namespace cliquevo::tools
