// SPDX-License-Identifier: BSD-3-Clause
// What is asked of cameras that no simulator stands for.
#include <algorithm>

#include <gtest/gtest.h>

#include "drivers/aravis/aravis_camera.h"

namespace cliquevo::drivers {
namespace {

using Settings = std::vector<FeatureSetting>;

TEST(AravisRequests, EachTriggerSetsTheFeaturesOfTheNamingConvention) {
  CameraOptions options;
  EXPECT_EQ(trigger_settings(options), (Settings{{"TriggerMode", "Off"}}));
  options.trigger = CameraTrigger::software;
  EXPECT_EQ(trigger_settings(options),
            (Settings{{"TriggerSelector", "FrameStart"}, {"TriggerMode", "On"}, {"TriggerSource", "Software"}}));
  options.trigger = CameraTrigger::hardware;
  options.trigger_line = "Line3";
  EXPECT_EQ(trigger_settings(options).back(), (FeatureSetting{"TriggerSource", "Line3"}));
  options.trigger = CameraTrigger::action;
  const Settings action = trigger_settings(options);
  EXPECT_NE(std::find(action.begin(), action.end(), FeatureSetting{"TriggerSource", "Action1"}), action.end());
  EXPECT_NE(std::find(action.begin(), action.end(), FeatureSetting{"ActionGroupMask", "1"}), action.end());
}

TEST(AravisRequests, AnActionCommandIsTheStandardsPacket) {
  const std::vector<std::uint8_t> packet = action_command(0x0102);
  const std::vector<std::uint8_t> wanted{0x42, 0x00, 0x01, 0x00, 0x00, 0x0c, 0x01, 0x02,   // command, length, request
                                         0x63, 0x6c, 0x71, 0x76,                           // device key
                                         0x00, 0x00, 0x00, 0x01, 0xff, 0xff, 0xff, 0xff};  // group key and mask
  EXPECT_EQ(packet, wanted);
}

TEST(AravisRequests, LostPacketsAreAskedForAgainWithinHalfAPeriodWhereThatIsWanted) {
  CameraOptions options;
  options.rate_hz = 20.0;
  options.packet_resend = true;
  EXPECT_EQ(stream_request(options), (StreamRequest{12'500, 25'000, true}));
  options.packet_resend = false;
  options.rate_hz = 1.0;
  EXPECT_EQ(stream_request(options), (StreamRequest{50'000, 100'000, false})) << "but never for long";
  options.rate_hz = 500.0;
  EXPECT_EQ(stream_request(options).frame_retention_us, 3'000U) << "nor shorter than packets take";
}

TEST(AravisRequests, PtpIsTurnedOnByEitherNameOfTheFeature) {
  EXPECT_STREQ(ptp_feature(true), "PtpEnable");
  EXPECT_STREQ(ptp_feature(false), "GevIEEE1588");
}

}  // namespace
}  // namespace cliquevo::drivers
