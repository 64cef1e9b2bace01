// SPDX-License-Identifier: BSD-3-Clause
#include "tools/reference_source.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

namespace cliquevo::tools {

namespace {

using daemon::StampedPose;

constexpr std::int64_t kTolerance_ns = 10'000'000;

class ReferencedSource final : public drivers::FrameSource {
 public:
  ReferencedSource(std::unique_ptr<drivers::FrameSource> source, daemon::Trajectory reference)
      : source_(std::move(source)), reference_(std::move(reference)) {
    std::stable_sort(reference_.poses.begin(), reference_.poses.end(), [this](const auto& a, const auto& b) {
      return by_stamp() ? a.stamp_ns < b.stamp_ns : a.frame < b.frame;
    });
  }

  const drivers::SourceInfo& info() const override { return source_->info(); }
  Result<bool> next(drivers::StereoPair& pair) override {
    auto more = source_->next(pair);
    if (!more || !*more) return more;
    pair.truth_T_world_camera.reset();
    if (const StampedPose* pose = pose_of(pair)) pair.truth_T_world_camera = pose->T_world_camera;
    return more;
  }
  void interrupt() override { source_->interrupt(); }
  std::string status() const override { return source_->status(); }
  std::string finding() const override { return source_->finding(); }
  std::string queues() const override { return source_->queues(); }

 private:
  bool by_stamp() const { return reference_.format == daemon::TrajectoryFormat::tum; }

  const StampedPose* pose_of(const drivers::StereoPair& pair) const {
    const auto& poses = reference_.poses;
    if (by_stamp()) return nearest(pair.stamp_ns);
    if (!reference_.numbered) {
      const auto line = static_cast<std::size_t>(pair.index);
      return line < poses.size() ? &poses[line] : nullptr;
    }
    const std::int64_t number = info().first_number + pair.index;
    const auto at = std::lower_bound(poses.begin(), poses.end(), number,
                                     [](const StampedPose& p, std::int64_t n) { return p.frame < n; });
    return at != poses.end() && at->frame == number ? &*at : nullptr;
  }

  const StampedPose* nearest(TimestampNs stamp_ns) const {
    const auto& poses = reference_.poses;
    const auto after = std::lower_bound(poses.begin(), poses.end(), stamp_ns,
                                        [](const StampedPose& p, TimestampNs t) { return p.stamp_ns < t; });
    const StampedPose* best = nullptr;
    for (const auto at : {after, after == poses.begin() ? after : std::prev(after)}) {
      if (at == poses.end()) continue;
      const std::int64_t off_ns = std::abs(at->stamp_ns - stamp_ns);
      if (off_ns <= kTolerance_ns && (best == nullptr || off_ns < std::abs(best->stamp_ns - stamp_ns))) best = &*at;
    }
    return best;
  }

  std::unique_ptr<drivers::FrameSource> source_;
  daemon::Trajectory reference_;
};

}  // namespace

std::unique_ptr<drivers::FrameSource> with_reference(std::unique_ptr<drivers::FrameSource> source,
                                                     daemon::Trajectory reference) {
  return std::make_unique<ReferencedSource>(std::move(source), std::move(reference));
}

}  // namespace cliquevo::tools
