// SPDX-License-Identifier: BSD-3-Clause
// The start-up lines state what the camera can measure.
#include "drivers/describe.h"

#include <gtest/gtest.h>

namespace cliquevo::drivers {
namespace {

TEST(describe, geometry_and_depth_error) {
  StereoModel m;
  m.width = 640;
  m.height = 480;
  m.fx_px = m.fy_px = 500.0;
  m.cx_px = 319.5;
  m.cy_px = 239.5;
  m.baseline_m = 0.2;
  const std::string text = describe_geometry(m);
  EXPECT_NE(text.find("baseline 0.2000 m"), std::string::npos) << text;
  EXPECT_NE(text.find("focal length 500.00 px"), std::string::npos) << text;
  EXPECT_NE(text.find("65.2 x 51.2 deg"), std::string::npos) << text;
  // z^2 / (f b) * 0.25 px
  EXPECT_NE(text.find("0.062 m at 5 m, 0.250 m at 10 m, 1.000 m at 20 m"), std::string::npos) << text;
  EXPECT_NE(describe_geometry(m, 1.0).find("1.00 px"), std::string::npos);
  EXPECT_NE(describe_geometry(m, 1.0).find("4.000 m at 20 m"), std::string::npos);
}

TEST(describe, source) {
  SourceInfo info;
  info.description = "KITTI odometry folder /data/06";
  info.width = 1226;
  info.height = 370;
  info.frame_count = 51;
  info.rate_hz = 10.0;
  info.calibration.source = "/data/06/calib.txt";
  info.calibration.rectified = true;
  EXPECT_EQ(describe_source(info),
            "source: KITTI odometry folder /data/06, 1226x370, 51 pairs, 10.00 Hz, rectified, calibration "
            "/data/06/calib.txt");
}

}  // namespace
}  // namespace cliquevo::drivers
