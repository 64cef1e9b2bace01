// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/trajectory_sink.h"

#include <optional>
#include <utility>

#include "core/base/caught.h"
#include "core/rt/ring.h"
#include "core/rt/thread.h"
#include "daemon/pipeline/trajectory_file.h"

namespace cliquevo::daemon {

namespace {

constexpr std::size_t kWaiting = 1 << 14;  // nine minutes at 30 Hz, 1.7 MB

}  // namespace

struct TrajectorySink::Impl {
  Impl(TrajectoryWriter writer_, std::string path_) : writer(std::move(writer_)), path(std::move(path_)) {}

  void write() {
    StampedPose pose;
    while (waiting.wait_pop(pose)) {
      if (error) continue;  // one error is enough; go on emptying the ring
      const auto ok = guarded("trajectory", [&] { return writer.append(pose.stamp_ns, pose.T_world_camera); });
      if (!ok) error = ok.error();
    }
  }

  TrajectoryWriter writer;
  std::string path;
  rt::Ring<StampedPose> waiting{kWaiting};
  std::int64_t left_out = 0;
  std::optional<Error> error;  // read once the thread is joined
  rt::Thread thread;
};

Result<TrajectorySink> TrajectorySink::open(const std::string& path) {
  auto writer = TrajectoryWriter::open(path, TrajectoryFormat::kitti);
  if (!writer) return writer.error();
  auto impl = std::make_unique<Impl>(std::move(*writer), path);
  auto thread = rt::Thread::start({.name = "vo-trajectory"}, [self = impl.get()] { self->write(); });
  if (!thread) return thread.error();
  impl->thread = std::move(*thread);
  return TrajectorySink(std::move(impl));
}

TrajectorySink::TrajectorySink(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TrajectorySink::TrajectorySink(TrajectorySink&&) noexcept = default;
TrajectorySink::~TrajectorySink() {
  if (impl_) static_cast<void>(close());
}

void TrajectorySink::append(TimestampNs stamp_ns, const RigidTransform& T_world_camera) {
  if (!impl_->waiting.push({stamp_ns, T_world_camera})) ++impl_->left_out;
}

Result<void> TrajectorySink::close() {
  impl_->waiting.close();
  impl_->thread.join();
  if (impl_->error) return *impl_->error;
  if (impl_->left_out > 0) {
    return Error{"trajectory incomplete", impl_->path,
                 std::to_string(impl_->left_out) + " poses left out: write to a faster disk"};
  }
  return {};
}

}  // namespace cliquevo::daemon
