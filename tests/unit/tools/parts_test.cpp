// SPDX-License-Identifier: BSD-3-Clause
// The small parts of the commands.
#include <gtest/gtest.h>

#include "tools/help_format.h"
#include "tools/progress.h"
#include "tools/run_log.h"
#include "tools/source_argument.h"

namespace cliquevo::tools {
namespace {

TEST(Progress, ABarShowsShareRateDistanceAndStatus) {
  EXPECT_EQ(progress_line(15, 30, 62.34, 47.06, "valid", true),
            "[===============>              ] 15/30  62.3 Hz  47.1 m  valid");
  EXPECT_EQ(progress_line(30, 30, 1, 0, "valid", true).substr(0, 32), "[==============================]");
}

TEST(Progress, WithoutATotalThereIsNoBar) { EXPECT_EQ(progress_line(7, -1, 5, 1, "x", true), "7  5.0 Hz  1.0 m  x"); }

TEST(Spread, IsMedianNinetyFifthPercentileAndMaximum) {
  std::vector<double> values;
  for (int i = 100; i >= 0; --i) values.push_back(i);
  const Spread s = spread_of(values);
  EXPECT_EQ(s.median, 50);
  EXPECT_EQ(s.p95, 95);
  EXPECT_EQ(s.max, 100);
  EXPECT_EQ(spread_of({}).max, 0);
  EXPECT_EQ(spread_of({3}).p95, 3);
}

FrameRecord frame(vo::Status status, double z) {
  FrameRecord out;
  out.estimate.status = status;
  out.estimate.T_world_camera.t.z() = z;
  return out;
}

TEST(RunLog, TheFirstFrameCannotFailAndDistanceAddsUp) {
  RunLog log;
  log.add(frame(vo::Status::no_data, 0));
  log.add(frame(vo::Status::valid, 1));
  log.add(frame(vo::Status::degenerate, 2));
  log.add(frame(vo::Status::valid, 1.5));
  EXPECT_EQ(log.failed(), (std::vector<std::size_t>{2}));
  EXPECT_NEAR(log.distance_m(), 2.5, 1e-12);
}

TEST(Source, SimulatorsAndRecordingsAreToldApartByName) {
  EXPECT_TRUE(is_simulator("sim"));
  EXPECT_TRUE(is_simulator("sim:frames=3"));
  EXPECT_FALSE(is_simulator("simulation"));
  EXPECT_FALSE(is_simulator("./sim"));
}

TEST(Source, OptionsThatMakeNoSenseTogetherAreWrongUsage) {
  SourceArgument argument;
  argument.text = "sim";
  EXPECT_TRUE(check_source(argument).ok());
  argument.every = 2;
  EXPECT_FALSE(check_source(argument).ok());
  argument.text = "/data/run";
  EXPECT_TRUE(check_source(argument).ok());
  argument.first = 5;
  argument.last = 4;
  EXPECT_FALSE(check_source(argument).ok());
}

TEST(Help, TextIsWrappedAtWords) {
  EXPECT_EQ(wrapped("one two three", 8), "one two\nthree");
  EXPECT_EQ(wrapped("unbreakable a", 3), "unbreakable\na");
  EXPECT_EQ(wrapped("", 3), "");
}

}  // namespace
}  // namespace cliquevo::tools
