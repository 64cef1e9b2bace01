// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plot.h"

#include <algorithm>
#include <string>

#include <opencv2/imgcodecs.hpp>

#include "tests/support/test_data.h"
#include "tools/chart.h"
#include "tools/output_file.h"
#include "tools/picture_format.h"

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

TEST(Plot, TheEndingSaysTheFormat) {
  RunPicture run = arc();
  run.title = "an <arc> & \xC3\xA9 \xff \x01";
  const auto begin = [&run](PictureFormat format) {
    const auto bytes = draw_plot(run, format);
    EXPECT_TRUE(bytes.ok());
    return std::string(bytes->begin(), bytes->begin() + 300);
  };
  EXPECT_TRUE(begin(PictureFormat::png).starts_with("\x89PNG"));
  EXPECT_NE(begin(PictureFormat::svg).find("<svg"), std::string::npos);
  EXPECT_TRUE(begin(PictureFormat::pdf).starts_with("%PDF"));
  EXPECT_EQ(*plot_format("a/run.SVG"), PictureFormat::svg);
  EXPECT_EQ(*plot_format("run.pdf"), PictureFormat::pdf);
  EXPECT_EQ(*plot_format("/dev/full"), PictureFormat::png);
  EXPECT_FALSE(plot_format("run.jpg").ok());
}

TEST(Plot, OneMetreIsAsLongOnBothAxes) {
  Figure figure(400, 300);
  const Color red{255, 0, 0};
  const Series square{"", {{0, 0}, {10, 0}, {10, 10}, {0, 10}, {0, 0}}, red, 2.0, Mark::none, 0.0, false};
  figure.draw({"", "", "", true, false, {square}}, {0, 0, 400, 300});
  const Picture picture = figure.render();
  int left = 400, right = 0, top = 300, bottom = 0;
  for (int y = 0; y < 300; ++y) {
    for (int x = 0; x < 400; ++x) {
      if (picture.at(x, y).green > 100 || picture.at(x, y).red < 200) continue;
      left = std::min(left, x), right = std::max(right, x), top = std::min(top, y), bottom = std::max(bottom, y);
    }
  }
  EXPECT_NEAR(right - left, bottom - top, 2);
  EXPECT_GT(right - left, 50);
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
