// SPDX-License-Identifier: BSD-3-Clause
// What is requested from cameras that no simulator stands for.
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

TEST(AravisSamples, EveryPackingOfMonoAndBayerIsKnown) {
  EXPECT_TRUE(aravis_samples(ARV_PIXEL_FORMAT_MONO_8).is_grey_bytes());
  EXPECT_EQ(aravis_samples(ARV_PIXEL_FORMAT_MONO_12).bits, 12);
  EXPECT_FALSE(aravis_samples(ARV_PIXEL_FORMAT_MONO_12).mosaic);
  EXPECT_TRUE(aravis_samples(ARV_PIXEL_FORMAT_BAYER_RG_8).mosaic);
  EXPECT_FALSE(aravis_samples(ARV_PIXEL_FORMAT_BAYER_RG_8).is_grey_bytes());
  EXPECT_TRUE(aravis_samples(ARV_PIXEL_FORMAT_MONO_10_PACKED).packed.has_value());
  EXPECT_EQ(aravis_samples(ARV_PIXEL_FORMAT_RGB_8_PACKED).bits, 0);
  EXPECT_EQ(aravis_samples(0).bits, 0);

  Image<std::uint8_t> out(4, 1);
  const auto expect = [&](ArvPixelFormat format, std::vector<std::uint8_t> data) {
    out.fill(0);
    ASSERT_TRUE(aravis_to_grey(aravis_samples(format), data.data(), data.size(), out.view())) << format;
    const std::uint8_t wanted[4] = {0x12, 0xff, 0x00, 0xa5};
    for (int x = 0; x < 4; ++x) EXPECT_EQ(out.cview()(x, 0), wanted[x]) << format << " " << x;
    EXPECT_FALSE(aravis_to_grey(aravis_samples(format), data.data(), data.size() - 1, out.view())) << format;
  };
  expect(ARV_PIXEL_FORMAT_MONO_8, {0x12, 0xff, 0x00, 0xa5});
  expect(ARV_PIXEL_FORMAT_MONO_10, {0x4b, 0x00, 0xff, 0x03, 0x01, 0x00, 0x94, 0x02});
  expect(ARV_PIXEL_FORMAT_MONO_16, {0x77, 0x12, 0x77, 0xff, 0x77, 0x00, 0x77, 0xa5});
  expect(ARV_PIXEL_FORMAT_MONO_12_PACKED, {0x12, 0x53, 0xff, 0x00, 0x12, 0xa5});
  expect(0x010c0047U, {0x23, 0xf1, 0xff, 0x07, 0x50, 0xa5});  // Mono12p: 0x123, 0xfff, 0x007, 0xa55
  expect(0x010a0046U, {0x4b, 0xfc, 0x1f, 0x00, 0xa5});        // Mono10p: 0x04b, 0x3ff, 0x001, 0x294
}

}  // namespace
}  // namespace cliquevo::drivers
