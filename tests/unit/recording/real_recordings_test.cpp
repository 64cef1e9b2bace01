// SPDX-License-Identifier: BSD-3-Clause
// The recordings that people have on their disks open as they are.
#include "drivers/describe.h"
#include "drivers/recording.h"
#include "tests/support/test_data.h"

namespace cliquevo::drivers {
namespace {

std::unique_ptr<FrameSource> open(const std::string& name, RecordingOptions options = {}) {
  options.path = test::data_dir() + "/" + name;
  auto source = open_recording(options);
  EXPECT_TRUE(source.ok()) << source.error().line();
  return source.ok() ? std::move(*source) : nullptr;
}

// Plays to the end; every pair must be whole, of one size, and later than the one before.
std::int64_t play(FrameSource& source) {
  StereoPair pair;
  std::int64_t count = 0;
  TimestampNs before = -1;
  for (;;) {
    const Result<bool> more = source.next(pair);
    if (!more.ok()) {
      ADD_FAILURE() << more.error().line();
      return count;
    }
    if (!*more) return count;
    EXPECT_TRUE(count == 0 || pair.stamp_ns > before);
    EXPECT_TRUE(pair.left.cview().same_size(source.info().width, source.info().height));
    EXPECT_TRUE(pair.right.cview().same_size(source.info().width, source.info().height));
    before = pair.stamp_ns;
    ++count;
  }
}

TEST(real_recordings, kitti_raw_is_unrectified_and_brings_its_rectification) {
  CLIQUEVO_NEEDS_DATA("kitti_raw");
  auto source = open("kitti_raw");
  ASSERT_TRUE(source);
  const SourceInfo& info = source->info();
  EXPECT_EQ(info.width, 1392);
  EXPECT_EQ(info.height, 512);
  EXPECT_NEAR(info.rate_hz, 9.7, 0.1);
  EXPECT_FALSE(info.calibration.rectified);
  ASSERT_TRUE(info.calibration.prescribed);
  EXPECT_EQ(info.calibration.prescribed->model.width, 1242);
  EXPECT_NEAR(info.calibration.prescribed->model.fx_px, 721.5377, 1e-9);
  EXPECT_NEAR(info.calibration.prescribed->model.baseline_m, 0.5372, 1e-4);
  StereoPair pair;
  ASSERT_TRUE(source->next(pair).ok());
  EXPECT_EQ(pair.stamp_ns, 1317045937977365760);  // the left camera's, exact
  EXPECT_EQ(1 + play(*source), info.frame_count);
  EXPECT_EQ(info.frame_count, 140);
}

TEST(real_recordings, kitti_odometry_is_rectified) {
  CLIQUEVO_NEEDS_DATA("kitti_odometry_06");
  auto source = open("kitti_odometry_06");
  ASSERT_TRUE(source);
  EXPECT_TRUE(source->info().calibration.rectified);
  EXPECT_NEAR(source->info().calibration.prescribed->model.baseline_m, 0.5372, 1e-4);
  EXPECT_EQ(source->info().calibration.prescribed->model.width, 1226);
  EXPECT_EQ(play(*source), 51);
}

TEST(real_recordings, two_folders_with_times_and_dso_calibration) {
  CLIQUEVO_NEEDS_DATA("zed_indoor");
  auto source = open("zed_indoor");
  ASSERT_TRUE(source);
  EXPECT_TRUE(source->info().calibration.rectified);
  StereoPair pair;
  ASSERT_TRUE(source->next(pair).ok());
  EXPECT_EQ(pair.stamp_ns, 1687709319100414000);
  EXPECT_EQ(1 + play(*source), 88);
}

}  // namespace
}  // namespace cliquevo::drivers
