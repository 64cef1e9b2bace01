// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view/facts.h"

#include <cmath>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>

#include "tools/view/base64.h"
#include "tools/view/pictures.h"

namespace cliquevo::view {
namespace {

TEST(Facts, AreJsonWhateverTheNumbersAre) {
  FrameFacts facts;
  facts.error_px = std::nan("");
  facts.T_world_body.t.x() = INFINITY;
  facts.checks[2] = {std::numeric_limits<double>::infinity(), 3.0, 2.0};
  facts.movers.push_back({7, true, {1, 2, 3}, 0.5, 1, 2, 3, 4});
  facts.points = {{1.0F, 2.0F, 3.0F}};
  const auto record = nlohmann::json::parse(to_json(facts, 5));
  EXPECT_EQ(record["n"], 5);
  EXPECT_EQ(record["e"], 0);
  EXPECT_EQ(record["ck"][2][1], 3);
  EXPECT_EQ(record["ck"][3].size(), 1U);
  EXPECT_EQ(record["mv"][0][0], 7);
  EXPECT_EQ(record["pt"].size(), 3U);
}

TEST(Facts, TheWayGrowsMoreUncertainAsTheMotionsAre) {
  WayUncertainty way;
  Matrix6d step = Matrix6d::Zero();
  step.diagonal() << 4e-4, 1e-4, 1e-4, 0, 0, 0;
  RigidTransform T;
  Eigen::Matrix3d place = way.add(false, T, step);
  EXPECT_TRUE(place.isZero());
  for (int i = 0; i < 9; ++i) {
    T.t.x() += 1.0;
    place = way.add(true, T, step);
  }
  EXPECT_NEAR(place(0, 0), 9 * 4e-4, 1e-12);
  EXPECT_NEAR(place(1, 1), 9 * 1e-4, 1e-12);
  // A failed frame's guess counts from the last valid one, and is forgotten after it.
  EXPECT_NEAR(way.add(false, T, 100.0 * step)(0, 0), 9 * 4e-4 + 4e-2, 1e-12);
  EXPECT_NEAR(way.add(true, T, step)(0, 0), 10 * 4e-4, 1e-12);
}

// A turn at the start moves what is far away most.
TEST(Facts, ATurnThatIsUncertainMovesTheEnd) {
  WayUncertainty way;
  Matrix6d step = Matrix6d::Zero();
  step(5, 5) = 1e-4;  // about the third axis
  RigidTransform T;
  way.add(false, T, step);
  T.t.x() = 1.0;
  way.add(true, T, step);
  T.t.x() = 101.0;
  EXPECT_NEAR(way.add(true, T, Matrix6d::Zero())(1, 1), 101.0 * 101.0 * 1e-4, 1e-6);
}

TEST(Pictures, DisparityComesBackWithinAStep) {
  Image<std::int16_t> disparity(40, 20);
  disparity.fill(kUnknownDisparity);
  for (int x = 0; x < 40; ++x) disparity.view().row(3)[x] = static_cast<std::int16_t>(x * 40 - 100);
  const DisparityPicture picture = encode_disparity(disparity.cview());
  const cv::Mat levels = cv::imdecode(picture.png, cv::IMREAD_UNCHANGED);
  ASSERT_EQ(levels.type(), CV_8UC1);
  EXPECT_EQ(levels.at<unsigned char>(0, 0), 0);
  for (int x = 0; x < 40; ++x) {
    const double px = std::max(0.0, (x * 40 - 100) / 16.0);
    const int level = levels.at<unsigned char>(3, x);
    const double step = picture.step_px;
    EXPECT_NEAR(level * step, px, step) << x;
    EXPECT_EQ(level == 0, px <= 0.0) << x;
  }
}

TEST(Pictures, JpegIsThePictureAndNothingIsNothing) {
  Image<std::uint8_t> grey(64, 48);
  for (int y = 0; y < 48; ++y) {
    for (int x = 0; x < 64; ++x) grey.view().row(y)[x] = static_cast<std::uint8_t>(2 * x + y);
  }
  JpegEncoder encoder;
  for (int again = 0; again < 3; ++again) {
    const cv::Mat decoded = cv::imdecode(encoder.encode(grey.cview(), 90), cv::IMREAD_UNCHANGED);
    ASSERT_EQ(decoded.size(), cv::Size(64, 48));
    EXPECT_NEAR(decoded.at<unsigned char>(20, 30), 80, 6);
  }
  EXPECT_TRUE(encoder.encode({}, 90).empty());
}

TEST(Base64, IsAsTheStandardHasIt) {
  const auto of = [](std::string_view text) {
    return base64({reinterpret_cast<const unsigned char*>(text.data()), text.size()});
  };
  EXPECT_EQ(of(""), "");
  EXPECT_EQ(of("f"), "Zg==");
  EXPECT_EQ(of("fo"), "Zm8=");
  EXPECT_EQ(of("foo"), "Zm9v");
  EXPECT_EQ(of("foobar"), "Zm9vYmFy");
}

}  // namespace
}  // namespace cliquevo::view
