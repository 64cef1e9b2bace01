// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plot.h"

#include <opencv2/imgcodecs.hpp>

#include "tests/support/test_data.h"
#include "tools/output_file.h"

namespace cliquevo::tools {
namespace {

RunPicture arc() {
  RunPicture run;
  run.title = "an arc";
  RigidTransform T;
  for (int i = 0; i < 200; ++i) {
    run.trajectory.push_back(T);
    T = T * perturb_left({}, (Vector6d() << 0, 0, 0.5, 0, 0.01, 0).finished());
  }
  return run;
}

cv::Mat drawn(const RunPicture& run) {
  const auto png = draw_plot(run);
  EXPECT_TRUE(png.ok());
  return cv::imdecode(*png, cv::IMREAD_COLOR);
}

int reddish(const cv::Mat& picture) {
  cv::Mat found;
  cv::inRange(picture, cv::Scalar(0, 0, 180), cv::Scalar(80, 80, 255), found);
  return cv::countNonZero(found);
}

TEST(Plot, IsAPictureOfTheStatedSize) { EXPECT_EQ(drawn(arc()).size(), cv::Size(1600, 760)); }

TEST(Plot, FailedFramesAreRed) {
  RunPicture run = arc();
  EXPECT_EQ(reddish(drawn(run)), 0);
  run.failed = {20, 21, 22};
  EXPECT_GT(reddish(drawn(run)), 50);
}

TEST(Plot, AReferenceChangesThePicture) {
  RunPicture run = arc();
  const cv::Mat without = drawn(run);
  for (std::size_t i = 0; i < run.trajectory.size(); ++i) {
    PosePair pair{0, i, run.trajectory[i], run.trajectory[i]};
    pair.reference.t *= 1.05;
    run.pairs.push_back(pair);
  }
  EXPECT_GT(cv::norm(without, drawn(run), cv::NORM_L1), 1e5);
}

TEST(Plot, NothingToDrawIsAnError) { EXPECT_FALSE(draw_plot({}).ok()); }

TEST(OutputFile, AnImpossiblePathShowsAtOnceAndAFullDiskAtTheEnd) {
  EXPECT_FALSE(OutputFile::open("/nowhere/plot.png", "plot").ok());
  auto full = OutputFile::open("/dev/full", "plot");
  ASSERT_TRUE(full.ok());
  EXPECT_FALSE(full->write(std::string("x")).ok());
}

}  // namespace
}  // namespace cliquevo::tools
