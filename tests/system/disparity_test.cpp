// SPDX-License-Identifier: BSD-3-Clause
// `cliquevo disparity`: its file format and its promises.
#include <fstream>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"
#include "tests/system/made_recording.h"

namespace cliquevo::test {
namespace {

cv::Mat disparity(const std::string& left, const std::string& right, std::vector<std::string> options = {}) {
  const std::string out = scratch_dir() + "/d.png";
  options.insert(options.begin(), {binary("cliquevo"), "disparity", left, right, "--out", out});
  const Finished done = run(options);
  EXPECT_EQ(done.exit_code, 0) << done.err;
  EXPECT_EQ(done.err, "");
  return cv::imread(out, cv::IMREAD_UNCHANGED);
}

// A random texture seen with the same disparity everywhere.
std::pair<std::string, std::string> plane(int disparity_px) {
  cv::Mat texture(200, 400, CV_8UC1);
  cv::theRNG().state = 7;
  cv::randu(texture, 0, 255);
  cv::GaussianBlur(texture, texture, {5, 5}, 1.0);
  const std::string folder = scratch_dir();
  // What is at u in the left camera is at u - d in the right one.
  cv::imwrite(folder + "/left.png", texture(cv::Rect(0, 0, 320, 200)));
  cv::imwrite(folder + "/right.png", texture(cv::Rect(disparity_px, 0, 320, 200)));
  return {folder + "/left.png", folder + "/right.png"};
}

TEST(Disparity, IsPixelsTimes256In16Bits) {
  const auto [left, right] = plane(20);
  const cv::Mat d = disparity(left, right, {"--max-disparity", "64"});
  ASSERT_EQ(d.type(), CV_16UC1);
  ASSERT_EQ(d.size(), cv::Size(320, 200));
  const cv::Mat inner = d(cv::Rect(100, 20, 200, 160));
  cv::Mat right_ones;
  cv::inRange(inner, 20 * 256 - 32, 20 * 256 + 32, right_ones);
  EXPECT_GT(cv::countNonZero(right_ones), 0.95 * static_cast<double>(inner.total()));
}

TEST(Disparity, SearchesSoManyDisparitiesFromZero) {
  const auto [left, right] = plane(20);
  for (const char* n : {"16", "20"}) {
    const cv::Mat d = disparity(left, right, {"--max-disparity", n});
    double most = 0.0;
    cv::minMaxLoc(d, nullptr, &most);
    EXPECT_LE(most, (std::stod(n) - 1) * 256) << n;
    EXPECT_LT(cv::countNonZero(d), 0.2 * static_cast<double>(d.total())) << n;
  }
  EXPECT_GT(cv::countNonZero(disparity(left, right, {"--max-disparity", "22"})), 32000);
}

TEST(Disparity, ColourInputsBecomeGrey) {
  const auto [left, right] = plane(12);
  const std::string folder = scratch_dir();
  cv::imwrite(folder + "/l.png", cv::imread(left, cv::IMREAD_COLOR));
  cv::imwrite(folder + "/r.png", cv::imread(right, cv::IMREAD_COLOR));
  EXPECT_EQ(cv::norm(disparity(left, right), disparity(folder + "/l.png", folder + "/r.png"), cv::NORM_L1), 0.0);
}

TEST(Disparity, ThePictureToLookAtIsInColour) {
  const auto [left, right] = plane(12);
  const std::string color = scratch_dir() + "/c.png";
  disparity(left, right, {"--color", color});
  EXPECT_EQ(cv::imread(color, cv::IMREAD_UNCHANGED).type(), CV_8UC3);
}

TEST(Disparity, BadImagesAreOneLineAndExitCode1) {
  const auto [left, right] = plane(12);
  const std::string folder = scratch_dir();
  cv::imwrite(folder + "/small.png", cv::Mat(100, 100, CV_8UC1, cv::Scalar(7)));
  std::ofstream(folder + "/text.png") << "text";
  cv::imwrite(folder + "/torn.png", cv::imread(right));
  tear(folder + "/torn.png");
  for (const std::string& bad :
       {folder + "/small.png", folder + "/text.png", folder + "/torn.png", folder + "/none.png"}) {
    const Finished done = run({binary("cliquevo"), "disparity", left, bad, "--out", folder + "/d.png"});
    EXPECT_EQ(done.exit_code, 1);
    EXPECT_EQ(lines_of(done.err).size(), 1u) << done.err;
    EXPECT_NE(done.err.find(bad), std::string::npos) << done.err;
  }
  EXPECT_EQ(run({binary("cliquevo"), "disparity", left, right, "--out", "/nowhere/d.png"}).exit_code, 1);
}

TEST(Disparity, IsRightOnARecordedIndoorPair) {
  CLIQUEVO_NEEDS_DATA("middlebury_motorcycle");
  const std::string folder = data_dir() + "/middlebury_motorcycle";
  const cv::Mat truth = cv::imread(folder + "/disparity.png", cv::IMREAD_UNCHANGED);
  const cv::Mat d = disparity(folder + "/left.png", folder + "/right.png", {"--max-disparity", "64"});
  ASSERT_EQ(d.size(), truth.size());
  int known = 0;
  int wrong = 0;
  for (int y = 0; y < d.rows; ++y) {
    for (int x = 0; x < d.cols; ++x) {
      const int ours = d.at<std::uint16_t>(y, x);
      const int theirs = truth.at<std::uint16_t>(y, x);
      if (ours == 0 || theirs == 0) continue;
      ++known;
      if (std::abs(ours - theirs) > 2 * 256) ++wrong;
    }
  }
  EXPECT_GT(known, 0.4 * static_cast<double>(d.total()));
  EXPECT_LT(wrong, 0.1 * known);
}

}  // namespace
}  // namespace cliquevo::test
