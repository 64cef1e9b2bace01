// SPDX-License-Identifier: BSD-3-Clause
// LCM logs as others write them: compressed images, several channels, clocks that step back, calibrations that change.
#include <filesystem>

#include <fmt/format.h>

#include "drivers/camera_order_watch.h"
#include "drivers/recording.h"
#include "drivers/recording/calibration_message.h"
#include "drivers/recording/event_log.h"
#include "drivers/recording/stereo_message.h"
#include "tests/support/test_data.h"
#include "tests/unit/drivers/made_up_source.h"
#include "tests/unit/recording/fixtures.h"

namespace cliquevo::drivers {
namespace {

using test::expect_open_error;

RecordingOptions of_field(const std::string& log) {
  RecordingOptions options;
  options.path = test::field_dir() + "/22-lcm-logs/" + log;
  options.calibration = test::field_dir() + "/22-lcm-logs/calib.txt";
  return options;
}

struct Played {
  std::vector<TimestampNs> stamps;
  std::vector<Error> errors;
};
Played play(const RecordingOptions& options) {
  Played out;
  auto source = open_recording(options);
  EXPECT_TRUE(source.ok()) << source.error().line();
  if (!source.ok()) return out;
  StereoPair pair;
  for (;;) {
    const auto more = (*source)->next(pair);
    if (more.ok() && !*more) return out;
    if (more.ok()) out.stamps.push_back(pair.stamp_ns);
    if (!more.ok()) out.errors.push_back(more.error());
  }
}

TEST(logs, motion_jpeg_of_the_field_plays) {
  CLIQUEVO_NEEDS_FIELD("22-lcm-logs");
  const Played played = play(of_field("jpeg.lcm"));
  EXPECT_EQ(played.stamps.size(), 3U);
  EXPECT_TRUE(played.errors.empty());
}

TEST(logs, a_clock_of_the_field_that_steps_back_costs_one_pair) {
  CLIQUEVO_NEEDS_FIELD("22-lcm-logs");
  const Played played = play(of_field("step_back.lcm"));
  ASSERT_EQ(played.stamps.size(), 3U);
  EXPECT_NEAR((*open_recording(of_field("step_back.lcm")))->info().rate_hz, 10.0, 1e-6);
  EXPECT_EQ(played.stamps[1] - played.stamps[0], 100'000'000);
  EXPECT_EQ(played.stamps[2] - played.stamps[1], 200'000'000) << "the skipped one between them";
  ASSERT_EQ(played.errors.size(), 1U);
  test::expect_clear(played.errors[0], {"out of order", "step_back.lcm, pair 2", "steps back by 0.25 s"});
}

TEST(logs, two_channels_of_the_field_are_asked_about) {
  CLIQUEVO_NEEDS_FIELD("22-lcm-logs");
  RecordingOptions options = of_field("two_channels.lcm");
  expect_open_error(options,
                    {"several stereo channels", "FRONT_STEREO (3 pairs)", "REAR_STEREO (3 pairs)", "--channel"});
  options.channel = "REAR";
  expect_open_error(options, {"REAR", "REAR_STEREO"});
  options.channel = "REAR_STEREO";
  EXPECT_EQ(play(options).stamps.size(), 3U);
}

// Writes `count` pairs on a channel, with a calibration before them.
void write(EventLogWriter& log, const SourceInfo& info, const std::string& channel, std::int64_t first, int count,
           bool calibration = true) {
  std::vector<std::uint8_t> bytes;
  StereoPair pair;
  test::make_up_pair(first, info, pair);
  if (calibration) {
    bytes = encode_calibration(info, pair.stamp_ns);
    ASSERT_TRUE(log.write(kCalibrationChannel, bytes.data(), bytes.size(), pair.stamp_ns / 1000).ok());
  }
  for (std::int64_t i = first; i < first + count; ++i) {
    test::make_up_pair(i, info, pair);
    encode_stereo(pair, bytes);
    ASSERT_TRUE(log.write(channel, bytes.data(), bytes.size(), pair.stamp_ns / 1000).ok());
  }
}

TEST(logs, a_second_stereo_channel_beside_ours_is_asked_about_and_pictures_of_disparity_are_none) {
  RecordingOptions options;
  options.path = test::scratch_dir() + "/a.lcm";
  auto log = EventLogWriter::create(options.path);
  ASSERT_TRUE(log.ok());
  write(*log, test::made_up_info(), kStereoChannel, 0, 4);
  EXPECT_EQ(play(options).stamps.size(), 4U);
  write(*log, test::made_up_info(), "STEREO_REAR", 4, 2, false);
  expect_open_error(options, {"several stereo channels", "VO_STEREO (4 pairs)", "STEREO_REAR (2 pairs)"});
  options.channel = "VO_STEREO";
  EXPECT_EQ(play(options).stamps.size(), 4U);
}

TEST(logs, a_later_calibration_that_differs_is_refused_and_its_parts_play) {
  RecordingOptions options;
  options.path = test::scratch_dir() + "/a.lcm";
  auto log = EventLogWriter::create(options.path);
  ASSERT_TRUE(log.ok());
  SourceInfo info = test::made_up_info();
  write(*log, info, kStereoChannel, 0, 3);
  info.description = "the same rig, recorded on another day";
  write(*log, info, kStereoChannel, 3, 2);
  EXPECT_EQ(play(options).stamps.size(), 5U);
  info.calibration.left.fx_px += 1.0;
  write(*log, info, kStereoChannel, 5, 2);
  expect_open_error(options, {"another calibration", "pair 5", "--last 4", "--first 5"});
  options.first = 5;
  auto source = open_recording(options);
  ASSERT_TRUE(source.ok()) << source.error().line();
  EXPECT_EQ((*source)->info().calibration.left.fx_px, info.calibration.left.fx_px);
  options.first = 0;
  options.last = 4;
  source = open_recording(options);
  ASSERT_TRUE(source.ok());
  EXPECT_EQ((*source)->info().calibration.left.fx_px, info.calibration.left.fx_px - 1.0);
}

TEST(logs, an_event_that_cannot_be_decoded_costs_its_pair) {
  RecordingOptions options;
  options.path = test::scratch_dir() + "/a.lcm";
  auto log = EventLogWriter::create(options.path);
  ASSERT_TRUE(log.ok());
  write(*log, test::made_up_info(), kStereoChannel, 0, 3);
  StereoPair pair;
  std::vector<std::uint8_t> bytes;
  test::make_up_pair(3, test::made_up_info(), pair);
  encode_stereo(pair, bytes);
  ASSERT_TRUE(log->write(kStereoChannel, bytes.data(), bytes.size() / 2, pair.stamp_ns / 1000).ok());
  write(*log, test::made_up_info(), kStereoChannel, 4, 2);
  const Played played = play(options);
  EXPECT_EQ(played.stamps.size(), 5U);
  ASSERT_EQ(played.errors.size(), 1U);
  test::expect_clear(played.errors[0], {"stereo message", "pair 3"});
}

// Any source's pairs, to look at what is made of them.
TEST(camera_order_watch, exchanges_images_masks_and_offsets_and_keeps_the_calibration) {
  const std::string dir = test::write_kitti_odometry(test::scratch_dir(), 3);
  test::write_image(dir + "/mask_left.png", 64, 48, 5);
  RecordingOptions options;
  options.path = dir;
  auto source = open_recording(options);
  ASSERT_TRUE(source.ok());
  const auto swapped = watch_camera_order(std::move(*source), true);
  EXPECT_NE(swapped->info().description.find("swapped"), std::string::npos);
  EXPECT_TRUE(swapped->info().left_mask.empty());
  EXPECT_FALSE(swapped->info().right_mask.empty());
  StereoPair pair;
  ASSERT_TRUE(swapped->next(pair).ok());
  EXPECT_EQ(pair.left.cview()(0, 0), test::pixel_of(0, 0, 1));
  EXPECT_EQ(pair.right.cview()(0, 0), test::pixel_of(0, 0, 0));
}

TEST(camera_order_watch, exchanged_cameras_of_the_field_are_reported_and_swapping_puts_them_right) {
  CLIQUEVO_NEEDS_FIELD("17-eyes-swapped");
  for (const bool swap : {false, true}) {
    RecordingOptions options;
    options.path = test::field_dir() + "/17-eyes-swapped";
    auto source = open_recording(options);
    ASSERT_TRUE(source.ok()) << source.error().line();
    const auto watched = watch_camera_order(std::move(*source), swap);
    StereoPair pair;
    while (*watched->next(pair)) continue;
    EXPECT_EQ(watched->finding().find("left and right are exchanged") != std::string::npos, !swap)
        << watched->finding();
    EXPECT_EQ(watched->status(), watched->finding());
  }
}

TEST(camera_order_watch, real_recordings_are_as_they_say) {
  for (const char* name : {"kitti_odometry_06", "kitti_raw", "zed_indoor", "euroc_shaken", "walk_backyard",
                           "karlsruhe_0019", "rover_minnie"}) {
    CLIQUEVO_NEEDS_DATA(name);
    for (const bool swap : {false, true}) {
      RecordingOptions options;
      options.path = test::data_dir() + "/" + name;
      options.last = std::string(name) == "rover_minnie" ? 1 : 7;
      auto source = open_recording(options);
      ASSERT_TRUE(source.ok()) << source.error().line();
      const auto watched = watch_camera_order(std::move(*source), swap);
      StereoPair pair;
      while (*watched->next(pair)) continue;
      EXPECT_EQ(watched->finding().empty(), !swap) << name << ": " << watched->finding();
    }
  }
}

}  // namespace
}  // namespace cliquevo::drivers
