// SPDX-License-Identifier: BSD-3-Clause
// Live cameras whose first pairs contradict their calibration are reported, once, and delivered all the same.
#include "daemon/first_pairs.h"

#include <mutex>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/noise_picture.h"
#include "tests/unit/drivers/made_up_source.h"

namespace cliquevo::daemon {
namespace {

// A wall 12 px of disparity away, seen by rectified cameras.
class Wall final : public drivers::FrameSource {
 public:
  Wall(bool rectified, bool live) {
    info_ = test::made_up_info(640, 480);
    info_.live = live;
    for (CameraCalibration* camera : {&info_.calibration.left, &info_.calibration.right}) {
      camera->fx_px = camera->fy_px = 400.0;
      camera->cx_px = 320.0;
      camera->cy_px = 240.0;
    }
    if (rectified) {
      info_.calibration.rectified = true;
      info_.calibration.prescribed = PrescribedRectification{};
      info_.calibration.prescribed->model = {640, 480, 400, 400, 320, 240, 0.12, 0};
    } else {
      info_.calibration.T_right_left.R = so3_exp({0.03, 0.0, 0.02});
    }
  }
  const drivers::SourceInfo& info() const override { return info_; }
  Result<bool> next(drivers::StereoPair& pair) override {
    if (index_ == 40) return false;
    pair.index = index_++;
    pair.left.copy_from(left_.cview());
    pair.right.copy_from(right_.cview());
    return true;
  }

 private:
  drivers::SourceInfo info_;
  std::int64_t index_ = 0;
  Image<std::uint8_t> left_ = test::noise_picture(640, 480, 0.0, 0.0);
  Image<std::uint8_t> right_ = test::noise_picture(640, 480, 12.0, 0.0);
};

std::vector<std::string> reported(bool rectified, bool live) {
  std::vector<std::string> lines;
  std::mutex mutex;
  int pairs = 0;
  {
    auto source = examine_first_pairs(std::make_unique<Wall>(rectified, live), [&](const std::string& line) {
      const std::lock_guard<std::mutex> lock(mutex);
      lines.push_back(line);
    });
    drivers::StereoPair pair;
    for (;;) {
      const auto more = source->next(pair);
      EXPECT_TRUE(more.ok());
      if (!more.ok() || !*more) break;
      EXPECT_EQ(pair.index, pairs++);
    }
  }
  EXPECT_EQ(pairs, 40);
  return lines;
}

TEST(first_pairs, rectified_images_of_live_cameras_are_reported_once) {
  const std::vector<std::string> lines = reported(false, true);
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_NE(lines[0].find("rectified already"), std::string::npos) << lines[0];
}

TEST(first_pairs, a_calibration_that_fits_is_not_reported) {
  EXPECT_TRUE(reported(true, true).empty());
  EXPECT_TRUE(reported(false, false).empty());  // recordings were looked at before
}

}  // namespace
}  // namespace cliquevo::daemon
