// SPDX-License-Identifier: BSD-3-Clause
// Folders of pictures from which nothing can be calibrated: what `cliquevo calibrate` says of each.
#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "drivers/simulator.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {
namespace {

namespace fs = std::filesystem;

// A folder of pairs.
class Pairs {
 public:
  Pairs() : folder_(scratch_dir()) {
    for (const char* side : {"left", "right"}) fs::create_directories(folder_ + "/" + side);
  }
  void add(const cv::Mat& left, const cv::Mat& right) {
    const std::string name = fmt::format("/{:02}.png", count_++);
    cv::imwrite(folder_ + "/left" + name, left);
    cv::imwrite(folder_ + "/right" + name, right);
  }
  std::string calibrated(const std::string& board) const {
    const std::string out = folder_ + "/rig.yaml";
    const Finished done = run({binary("cliquevo"), "calibrate", folder_, "--board", board, "--out", out});
    EXPECT_EQ(done.exit_code, 1) << done.out;
    EXPECT_FALSE(std::ifstream(out).good()) << "nothing is written";
    const auto lines = lines_of(done.err);
    return lines.empty() ? "" : lines.back();
  }

 private:
  std::string folder_;
  int count_ = 0;
};

// A chessboard of 9 x 6 corners that faces the camera, its first corner at (x, y).
cv::Mat facing(int side_px, int x, int y) {
  cv::Mat out(480, 640, CV_8U, 200);
  for (int row = 0; row <= 6; ++row) {
    for (int column = 0; column <= 9; ++column) {
      if ((row + column) % 2 != 0) continue;
      cv::rectangle(out, cv::Rect(x + (column - 1) * side_px, y + (row - 1) * side_px, side_px, side_px), 30,
                    cv::FILLED);
    }
  }
  return out;
}

TEST(CalibratePictures, OfABoardThatAlwaysFacesTheCamerasAreRefused) {
  Pairs pairs;
  for (int i = 0; i < 8; ++i) {
    const int side_px = 28 + 2 * i, x = 70 + 11 * i, y = 60 + 13 * (i % 5);
    pairs.add(facing(side_px, x, y), facing(side_px, x - side_px / 2, y));
  }
  const std::string said = pairs.calibrated("chessboard:9x6:0.03");
  EXPECT_NE(said.find("the views are all parallel"), std::string::npos) << said;
  EXPECT_NE(said.find("tilt the board"), std::string::npos) << said;
}

TEST(CalibratePictures, OfOneCameraAloneAreRefused) {
  Pairs pairs;
  for (int i = 0; i < 6; ++i) pairs.add(facing(30 + i, 80 + 9 * i, 90), cv::Mat(480, 640, CV_8U, 90));
  const std::string said = pairs.calibrated("chessboard:9x6:0.03");
  EXPECT_NE(said.find("the right camera never saw the board"), std::string::npos) << said;
}

TEST(CalibratePictures, ThatAreMirroredAreNamedAsSuch) {
  Pairs pairs;
  const auto options = drivers::parse_simulator_options("board=charuco:9x6:0.03,frames=3,board_hold_s=0");
  const auto source = drivers::open_simulator(*options);
  ASSERT_TRUE(source.ok());
  drivers::StereoPair pair;
  while (*(*source)->next(pair)) {
    std::array<cv::Mat, 2> mirrored;
    for (const bool right : {false, true}) {
      auto& image = right ? pair.right : pair.left;
      const cv::Mat seen(image.height(), image.width(), CV_8U, image.view().data,
                         static_cast<std::size_t>(image.view().stride));
      cv::flip(seen, mirrored[right ? 1 : 0], 1);
    }
    pairs.add(mirrored[0], mirrored[1]);
  }
  const std::string said = pairs.calibrated("charuco:9x6:0.03");
  EXPECT_NE(said.find("a mirror is in the way"), std::string::npos) << said;
}

}  // namespace
}  // namespace cliquevo::test
