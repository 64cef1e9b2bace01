// SPDX-License-Identifier: BSD-3-Clause
#include "tools/reference_source.h"

#include <gtest/gtest.h>

namespace cliquevo::tools {
namespace {

// Pairs 0, 2, 4, ... a tenth of a second apart; images are of no interest here.
class EverySecond final : public drivers::FrameSource {
 public:
  EverySecond() { info_.first_number = 100; }
  const drivers::SourceInfo& info() const override { return info_; }
  Result<bool> next(drivers::StereoPair& pair) override {
    if (next_ >= 10) return false;
    pair.index = next_;
    pair.stamp_ns = 1'000'000'000 + 50'000'000 * next_;
    next_ += 2;
    return true;
  }
  std::string finding() const override { return "found"; }

 private:
  drivers::SourceInfo info_;
  std::int64_t next_ = 0;
};

daemon::StampedPose pose(double x, TimestampNs stamp_ns, std::int64_t frame) {
  daemon::StampedPose out;
  out.T_world_camera.t.x() = x;
  out.stamp_ns = stamp_ns;
  out.frame = frame;
  return out;
}

// x of each pair's pose; -1 where it has none.
std::vector<double> poses_of(daemon::Trajectory reference) {
  const auto source = with_reference(std::make_unique<EverySecond>(), std::move(reference));
  EXPECT_EQ(source->finding(), "found");
  std::vector<double> out;
  drivers::StereoPair pair;
  for (auto more = source->next(pair); more && *more; more = source->next(pair)) {
    out.push_back(pair.truth_T_world_camera ? pair.truth_T_world_camera->t.x() : -1.0);
  }
  return out;
}

TEST(ReferenceSource, LinesBelongToPositionsInTheRecording) {
  daemon::Trajectory reference;
  for (int i = 0; i < 7; ++i) reference.poses.push_back(pose(i, 0, -1));
  EXPECT_EQ(poses_of(std::move(reference)), (std::vector<double>{0, 2, 4, 6, -1})) << "it ends before the recording";
}

TEST(ReferenceSource, NumberedPosesBelongToTheFramesOfTheseNumbers) {
  daemon::Trajectory reference;
  reference.numbered = true;
  for (const int frame : {104, 102, 107}) reference.poses.push_back(pose(frame, 0, frame));
  EXPECT_EQ(poses_of(std::move(reference)), (std::vector<double>{-1, 102, 104, -1, -1}));
}

TEST(ReferenceSource, StampedPosesBelongToTheNearestPairWithinTenMilliseconds) {
  daemon::Trajectory reference;
  reference.format = daemon::TrajectoryFormat::tum;
  reference.poses.push_back(pose(1, 1'000'000'000 - 9'000'000, -1));
  reference.poses.push_back(pose(2, 1'100'000'000 + 3'000'000, -1));
  reference.poses.push_back(pose(3, 1'100'000'000 - 4'000'000, -1));
  reference.poses.push_back(pose(4, 1'200'000'000 + 11'000'000, -1));
  EXPECT_EQ(poses_of(std::move(reference)), (std::vector<double>{1, 2, -1, -1, -1}));
}

}  // namespace
}  // namespace cliquevo::tools
