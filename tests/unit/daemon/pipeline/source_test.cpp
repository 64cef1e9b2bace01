// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/source.h"

#include <cstdlib>
#include <vector>

#include <gtest/gtest.h>

#include "daemon/pipeline/pacer.h"

namespace cliquevo::daemon {
namespace {

// Frames distinguished by their grey level, with uneven gaps.
class Greys : public drivers::FrameSource {
 public:
  explicit Greys(int frames) : frames_(frames) {
    info_.width = 8;
    info_.height = 4;
    info_.frame_count = frames;
  }
  const drivers::SourceInfo& info() const override { return info_; }
  Result<bool> next(drivers::StereoPair& pair) override {
    if (at_ >= frames_) return false;
    pair.index = at_;
    pair.stamp_ns = 1'000 + 10 * at_ * at_;
    for (auto* image : {&pair.left, &pair.right}) {
      image->resize(8, 4);
      image->fill(static_cast<std::uint8_t>(at_));
    }
    ++at_;
    return true;
  }

 private:
  drivers::SourceInfo info_;
  int frames_;
  int at_ = 0;
};

TEST(PingPong, PlaysForwardThenBackwardWithStampsThatRiseAsTheWayDoes) {
  auto source = make_pingpong(std::make_unique<Greys>(4));
  ASSERT_TRUE(source.ok());
  EXPECT_EQ((*source)->info().frame_count, -1);
  const std::vector<int> expected{0, 1, 2, 3, 2, 1, 0, 1, 2, 3, 2};
  drivers::StereoPair pair;
  TimestampNs before_ns = 0;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const auto more = (*source)->next(pair);
    ASSERT_TRUE(more.ok() && *more);
    EXPECT_EQ(pair.index, static_cast<std::int64_t>(i));
    EXPECT_EQ(pair.left.view()(0, 0), expected[i]);
    EXPECT_EQ(pair.right.view()(7, 3), expected[i]);
    const auto way = [](int a, int b) { return std::abs(10 * (a * a - b * b)); };
    EXPECT_EQ(pair.stamp_ns - before_ns, i == 0 ? 1'000 : way(expected[i], expected[i - 1]));
    before_ns = pair.stamp_ns;
  }
}

TEST(PingPong, RefusesWhatItCannotPlay) {
  EXPECT_FALSE(make_pingpong(std::make_unique<Greys>(1)).ok());
  const auto too_large = make_pingpong(std::make_unique<Greys>(10), 100);
  ASSERT_FALSE(too_large.ok());
  EXPECT_NE(too_large.error().line().find("set first and last"), std::string::npos);
}

TEST(Pacer, KeepsTheRecordedPaceTimesTheSpeed) {
  Pacer pacer(2.0);
  EXPECT_EQ(pacer.due_ns(5'000, 100), 100);
  EXPECT_EQ(pacer.due_ns(6'000, 150), 600);
  EXPECT_EQ(pacer.due_ns(8'000, 700), 1'600);  // late by 100: the schedule stays
  EXPECT_EQ(pacer.due_ns(10'000, 1'610), 2'600);
}

TEST(Pacer, DoesNotCatchUpByABurstAfterALongDelay) {
  Pacer pacer(1.0);
  EXPECT_EQ(pacer.due_ns(0, 100), 100);
  EXPECT_EQ(pacer.due_ns(1'000, 50'000), 50'000);
  EXPECT_EQ(pacer.due_ns(2'000, 50'010), 51'000);
}

TEST(PingPong, StampsAtTheEndOfTheRangeStayInIt) {
  class Absurd : public Greys {
   public:
    Absurd() : Greys(2) {}
    Result<bool> next(drivers::StereoPair& pair) override {
      auto more = Greys::next(pair);
      pair.stamp_ns = pair.index == 0 ? INT64_MIN : INT64_MAX;
      return more;
    }
  };
  auto source = make_pingpong(std::make_unique<Absurd>());
  ASSERT_TRUE(source.ok());
  drivers::StereoPair pair;
  for (int i = 0; i < 6; ++i) ASSERT_TRUE((*source)->next(pair).ok());
  EXPECT_EQ(pair.stamp_ns, INT64_MAX);
}

TEST(Pacer, AStampFarAwayIsDueInACenturyAtMost) {
  for (const double speed : {1e-300, 1.0, 1e300}) {
    Pacer pacer(speed);
    for (const TimestampNs stamp_ns : {TimestampNs{0}, INT64_MAX, INT64_MIN, TimestampNs{1}}) {
      const std::int64_t due_ns = pacer.due_ns(stamp_ns, 1000);
      EXPECT_GE(due_ns, 1000);
      EXPECT_LT(due_ns, std::int64_t{4} << 60);
    }
  }
}

}  // namespace
}  // namespace cliquevo::daemon
