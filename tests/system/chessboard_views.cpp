// SPDX-License-Identifier: BSD-3-Clause
#include "tests/system/chessboard_views.h"

#include <algorithm>
#include <filesystem>

#include <gtest/gtest.h>
#include <opencv2/imgcodecs.hpp>

#include "tests/support/test_data.h"
#include "tools/calibrate/detector.h"

namespace cliquevo::test {

namespace fs = std::filesystem;
using calibration::Side;

ChessboardViews chessboard_views() {
  ChessboardViews out;
  out.board = {calibration::BoardKind::chessboard, 9, 6, 0.02423, 0.0};
  std::vector<std::string> endings;  // behind "left"
  for (const auto& entry : fs::directory_iterator(data_dir() + "/chessboard")) {
    const std::string name = entry.path().filename();
    if (name.starts_with("left")) endings.push_back(name.substr(4));
  }
  std::sort(endings.begin(), endings.end());
  const tools::BoardDetector detector(out.board);
  for (const std::string& ending : endings) {
    calibration::View view{ending, {}, {}};
    for (const Side side : {Side::left, Side::right}) {
      const std::string path = data_dir() + "/chessboard/" + (side == Side::left ? "left" : "right") + ending;
      const cv::Mat image = cv::imread(path, cv::IMREAD_GRAYSCALE);
      EXPECT_FALSE(image.empty()) << path;
      out.width = image.cols;
      out.height = image.rows;
      view.of(side) = detector.find({image.data, image.cols, image.rows, static_cast<std::ptrdiff_t>(image.step)});
    }
    out.views.push_back(view);
  }
  return out;
}

}  // namespace cliquevo::test
