// SPDX-License-Identifier: BSD-3-Clause
// Every lens goes into a recording's calibration message and comes out to the last bit.
#include <gtest/gtest.h>

#include "drivers/recording/calibration_message.h"

namespace cliquevo::drivers {
namespace {

TEST(message, keeps_every_lens) {
  for (const auto& [model, k] : {std::pair{Distortion::plumb_bob, std::array<double, 8>{-0.3, 0.1, 1e-4, 2e-4}},
                                 {Distortion::thin_prism, {0.1, 0.02, 1e-4, 2e-4, 0.01, 0.2, 0.03, 0.001}},
                                 {Distortion::unified, {1.2, -0.1, 0.02, 1e-3, 2e-3}},
                                 {Distortion::extended_unified, {0.6, 1.1}},
                                 {Distortion::double_sphere, {-0.2, 0.58}}}) {
    SourceInfo info;
    info.width = 640;
    info.height = 480;
    StereoCalibration& c = info.calibration;
    for (CameraCalibration* camera : {&c.left, &c.right}) {
      *camera = {640, 480, 400.0, 401.0, 320.0, 240.0, model, k, {}};
      if (model == Distortion::thin_prism) camera->prism = {1e-3, 2e-3, -1e-3, 5e-4, 0.01, -0.02};
    }
    c.T_right_left.t = {-0.1, 0.0, 0.0};
    c.source = "rig.yaml";
    const auto bytes = encode_calibration(info, 1'000'000);
    const auto back = parse_calibration_message(bytes.data(), bytes.size(), "log");
    ASSERT_TRUE(back.ok()) << back.error().line();
    EXPECT_EQ(back->calibration.left.distortion, model);
    EXPECT_EQ(back->calibration.right.coefficients, k);
    EXPECT_EQ(back->calibration.left.prism, c.left.prism);
  }
}

TEST(message, a_baseline_that_was_accepted_once_plays_again) {
  SourceInfo info;
  info.width = 640;
  info.height = 480;
  for (CameraCalibration* camera : {&info.calibration.left, &info.calibration.right}) {
    *camera = {640, 480, 400.0, 401.0, 320.0, 240.0, Distortion::none, {}, {}};
  }
  info.calibration.T_right_left.t = {-4.4, 0.0, 0.0};
  const auto bytes = encode_calibration(info, 1'000'000);
  EXPECT_TRUE(parse_calibration_message(bytes.data(), bytes.size(), "log").ok());
}

}  // namespace
}  // namespace cliquevo::drivers
