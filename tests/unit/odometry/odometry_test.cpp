// SPDX-License-Identifier: BSD-3-Clause
#include "core/odometry/odometry.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <sys/mman.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "daemon/pipeline/frame_pipeline.h"
#include "drivers/simulator.h"

namespace cliquevo {
namespace {

using View = ImageView<const std::uint8_t>;

std::unique_ptr<drivers::Simulator> small_course(bool raw) {
  drivers::SimulatorOptions options;
  options.width = 160;
  options.height = 120;
  options.focal_px = 180.0;
  options.frames = 5;
  options.raw = raw;
  options.cache_dir = "none";
  options.workers = 1;
  auto source = drivers::open_simulator(options);
  EXPECT_TRUE(source.ok());
  return std::move(*source);
}

// The column of the leftmost feature that was looked at in the last frame.
double leftmost_px(const Odometry& odometry) {
  std::vector<vo::SeenFeature> features;
  odometry.list_features(features);
  double least = 1e9;
  for (const vo::SeenFeature& feature : features) least = std::min<double>(least, feature.x_px);
  return least;
}

OdometryParams small_params() {
  OdometryParams params;
  params.stereo.num_disparities = 64;
  return params;
}

bool same(const vo::Estimate& a, const vo::Estimate& b) {
  return a.status == b.status && a.inliers == b.inliers && a.T_world_camera.R == b.T_world_camera.R &&
         a.T_world_camera.t == b.T_world_camera.t && a.covariance == b.covariance;
}

Image<std::uint8_t> left_half_mask(int width, int height) {
  Image<std::uint8_t> mask(width, height);
  mask.fill(255);
  for (int y = 0; y < height; ++y) std::memset(mask.view().row(y), 0, static_cast<std::size_t>(width / 2));
  return mask;
}

// An image that ends where readable memory ends, and begins where it begins.
class GuardedImage {
 public:
  GuardedImage(View image, bool at_end) {
    const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    const std::size_t bytes = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
    const std::size_t pages = (bytes + page - 1) / page;
    size_ = (pages + 2) * page;
    base_ = static_cast<std::uint8_t*>(::mmap(nullptr, size_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    ::mprotect(base_ + page, pages * page, PROT_READ | PROT_WRITE);
    first_ = base_ + page + (at_end ? pages * page - bytes : 0);
    for (int y = 0; y < image.height; ++y) {
      std::memcpy(first_ + y * image.width, image.row(y), static_cast<std::size_t>(image.width));
    }
    ::mprotect(base_ + page, pages * page, PROT_READ);
    width_ = image.width;
    height_ = image.height;
  }
  ~GuardedImage() { ::munmap(base_, size_); }
  GuardedImage(const GuardedImage&) = delete;
  GuardedImage& operator=(const GuardedImage&) = delete;
  View view() const { return {first_, width_, height_, width_}; }

 private:
  std::size_t size_ = 0;
  std::uint8_t* base_ = nullptr;
  std::uint8_t* first_ = nullptr;
  int width_ = 0;
  int height_ = 0;
};

class OdometryOf : public testing::TestWithParam<bool> {};

TEST_P(OdometryOf, ImagesIsWhatTheFramePipelineMakesOfThem) {
  const auto source = small_course(GetParam());
  auto pipeline = daemon::FramePipeline::make({small_params().stereo, {}, {}}, source->info());
  auto odometry = Odometry::make(source->info().calibration, small_params());
  ASSERT_TRUE(pipeline.ok() && odometry.ok());
  drivers::StereoPair pair;
  int valid = 0;
  while (*source->next(pair)) {
    ASSERT_TRUE(pipeline->process(pair).ok());
    const auto estimate = odometry->step(pair.left.cview(), pair.right.cview(), pair.stamp_ns);
    ASSERT_TRUE(estimate.ok());
    EXPECT_TRUE(same(*estimate, pipeline->estimate()));
    valid += estimate->status == vo::Status::valid ? 1 : 0;
  }
  EXPECT_EQ(valid, 4);
}

TEST_P(OdometryOf, ImagesWithMasksIsWhatTheFramePipelineMakesOfThem) {
  const auto source = small_course(GetParam());
  drivers::SourceInfo info;
  info.width = source->info().width;
  info.height = source->info().height;
  info.calibration = source->info().calibration;
  info.left_mask = left_half_mask(info.width, info.height);
  info.right_mask = left_half_mask(info.width, info.height);
  auto pipeline = daemon::FramePipeline::make({small_params().stereo, {}, {}}, info);
  auto odometry = Odometry::make(info.calibration, small_params(), {info.left_mask.cview(), info.right_mask.cview()});
  auto without = Odometry::make(info.calibration, small_params());
  ASSERT_TRUE(pipeline.ok() && odometry.ok() && without.ok());
  drivers::StereoPair pair;
  while (*source->next(pair)) {
    ASSERT_TRUE(pipeline->process(pair).ok());
    const auto estimate = odometry->step(pair.left.cview(), pair.right.cview(), pair.stamp_ns);
    const auto all = without->step(pair.left.cview(), pair.right.cview(), pair.stamp_ns);
    ASSERT_TRUE(estimate.ok() && all.ok());
    EXPECT_TRUE(same(*estimate, pipeline->estimate()));
    // Rectification moves the mask's edge by some pixels.
    EXPECT_GT(leftmost_px(*odometry), info.width / 2 - 20);
    EXPECT_LT(leftmost_px(*without), info.width / 2 - 20);
  }
}

TEST_P(OdometryOf, ImagesReadsNothingOutsideThem) {
  const auto source = small_course(GetParam());
  auto plain = Odometry::make(source->info().calibration, small_params());
  auto guarded = Odometry::make(source->info().calibration, small_params());
  ASSERT_TRUE(plain.ok() && guarded.ok());
  drivers::StereoPair pair;
  bool at_end = false;
  while (*source->next(pair)) {
    at_end = !at_end;
    const GuardedImage left(pair.left.cview(), at_end);
    const GuardedImage right(pair.right.cview(), at_end);
    const auto expected = plain->step(pair.left.cview(), pair.right.cview(), pair.stamp_ns);
    const auto estimate = guarded->step(left.view(), right.view(), pair.stamp_ns);
    ASSERT_TRUE(expected.ok() && estimate.ok());
    EXPECT_TRUE(same(*estimate, *expected));
  }
}

INSTANTIATE_TEST_SUITE_P(Rectified, OdometryOf, testing::Values(false));
INSTANTIATE_TEST_SUITE_P(AsGrabbed, OdometryOf, testing::Values(true));

TEST(Odometry, RefusesImagesAndStampsThatCannotBeAndGoesOnAsBefore) {
  const auto source = small_course(false);
  const StereoModel& model = source->info().calibration.prescribed->model;
  auto odometry = Odometry::make(model, small_params());
  auto untroubled = Odometry::make(model, small_params());
  ASSERT_TRUE(odometry.ok() && untroubled.ok());
  drivers::StereoPair pair;
  while (*source->next(pair)) {
    const View left = pair.left.cview();
    const View right = pair.right.cview();
    const View low{left.data, left.width, left.height - 1, left.stride};
    const View close{left.data, left.width, left.height, left.width - 1};
    for (const auto& [l, r] : {std::pair{View{}, right}, {left, View{}}, {low, right}, {left, low}, {close, right}}) {
      const auto refused = odometry->step(l, r, pair.stamp_ns);
      ASSERT_FALSE(refused.ok());
      EXPECT_EQ(refused.error().what, "unusable frame");
      EXPECT_FALSE(refused.error().remedy.empty());
    }
    const auto estimate = odometry->step(left, right, pair.stamp_ns);
    ASSERT_TRUE(estimate.ok());
    EXPECT_TRUE(same(*estimate, *untroubled->step(left, right, pair.stamp_ns)));
    EXPECT_FALSE(odometry->step(left, right, pair.stamp_ns).ok());  // the stamp does not advance
  }
  odometry->reset();
  EXPECT_TRUE(odometry->step(pair.left.cview(), pair.right.cview(), 0).ok());
}

TEST(Odometry, RefusesModelsThatCannotBe) {
  StereoModel model;
  EXPECT_FALSE(Odometry::make(model).ok());
  model = {320, 240, 300.0, 300.0, 159.5, 119.5, 0.12};
  EXPECT_TRUE(Odometry::make(model).ok());
  model.baseline_m = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(Odometry::make(model).ok());
  model.baseline_m = 0.12;
  const Image<std::uint8_t> small(319, 240);
  const auto wrong_mask = Odometry::make(model, {}, {small.cview(), {}});
  ASSERT_FALSE(wrong_mask.ok());
  EXPECT_EQ(wrong_mask.error().line(),
            "unusable frame: the left mask has 319x240 px: give images of 320x240 px, as the calibration");
}

}  // namespace
}  // namespace cliquevo
