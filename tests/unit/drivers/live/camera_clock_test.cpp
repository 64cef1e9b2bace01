// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/live/camera_clock.h"

#include <gtest/gtest.h>

namespace cliquevo::drivers {
namespace {

constexpr std::int64_t kPeriodNs = 33'333'333;

// A camera that exposes regularly and whose frames arrive a millisecond later.
class Camera {
 public:
  CameraClock::Reading expose() {
    ++number_;
    return clock.read(stamp(), number_ * kPeriodNs + 1'000'000);
  }
  void lose(int frames) { number_ += frames; }
  void set_clock_ahead(std::int64_t by_ns) { offset_ns_ += by_ns; }
  TimestampNs stamp() const { return number_ * kPeriodNs + offset_ns_; }
  CameraClock clock{static_cast<double>(kPeriodNs)};

 private:
  std::int64_t number_ = 0;
  std::int64_t offset_ns_ = 5'000'000'000;
};

TEST(CameraClock, NumbersRegularExposuresOneByOneOnceItHasLearntThem) {
  Camera camera;
  for (int i = 0; i < 40; ++i) camera.expose();
  ASSERT_TRUE(camera.clock.locked());
  std::int64_t last = camera.expose().index;
  for (int i = 0; i < 100; ++i) {
    const CameraClock::Reading reading = camera.expose();
    EXPECT_EQ(reading.verdict, CameraClock::Verdict::certain);
    EXPECT_EQ(reading.index, last + 1);
    last = reading.index;
  }
  EXPECT_NEAR(camera.clock.period_ns(), static_cast<double>(kPeriodNs), 1000.0);
}

TEST(CameraClock, KnowsAFrameThatWasHereBefore) {
  Camera camera;
  for (int i = 0; i < 40; ++i) camera.expose();
  EXPECT_EQ(camera.clock.read(camera.stamp(), 41 * kPeriodNs).verdict, CameraClock::Verdict::doubled);
}

TEST(CameraClock, CountsWhatIsMissingAndIsCertainWithTheSecondFrameBehindTheGap) {
  Camera camera;
  for (int i = 0; i < 40; ++i) camera.expose();
  const std::int64_t before = camera.expose().index;
  camera.lose(3);
  const CameraClock::Reading first = camera.expose();
  EXPECT_EQ(first.missing, 3);
  EXPECT_EQ(first.index, before + 4);
  EXPECT_EQ(first.verdict, CameraClock::Verdict::held);
  EXPECT_TRUE(camera.expose().confirms);
}

TEST(CameraClock, AStepOffTheGridMakesItLearnAnew) {
  Camera camera;
  for (int i = 0; i < 40; ++i) camera.expose();
  camera.set_clock_ahead(kPeriodNs / 2);
  bool restarted = false;
  for (int i = 0; i < 6; ++i) restarted = camera.expose().restarted || restarted;
  EXPECT_TRUE(restarted);
  EXPECT_FALSE(camera.clock.locked());
}

}  // namespace
}  // namespace cliquevo::drivers
