// SPDX-License-Identifier: BSD-3-Clause
// What is sent over LCM and on which channels. A new message is a file in daemon/lcmtypes, a field and a row here, and
// its lines in daemon/lcm/publisher.cpp.
#pragma once

#include <string>

namespace cliquevo::daemon {

struct LcmConfig {
  std::string url = "udpm://239.255.76.67:7667?ttl=0";
  std::string delta_channel = "VO_DELTA_CAMERA";
  std::string pose_channel = "POSE_BODY";
  std::string status_channel = "VO_STATUS";
  std::string odometry_channel = "VO_ODOMETRY";
  std::string delta_body_channel;  // empty = off, as all that are not required
  std::string images_channel;
  std::string points_channel;
  std::string movers_channel;
  std::string features_channel;
  std::string health_channel = "VO_HEALTH";
  double images_rate_hz = 2.0;
  bool images_right = false;  // the right image, too
  double points_rate_hz = 2.0;
  int points_step_px = 4;
  std::string command_channel;  // received: see CommandReceiver
};

// The channels that messages go out on, a row each.
struct LcmChannel {
  const char* key;  // within the section lcm
  std::string LcmConfig::*name;
  bool required;
  const char* meaning;
};
inline constexpr std::size_t kLongestChannel = 63;  // LCM_MAX_CHANNEL_NAME_LENGTH
inline constexpr LcmChannel kLcmChannels[] = {
    {"delta_channel", &LcmConfig::delta_channel, true, "motion of the camera since the last valid frame"},
    {"pose_channel", &LcmConfig::pose_channel, true, "pose of the body where it started"},
    {"status_channel", &LcmConfig::status_channel, true, "status, counts, errors and times of each frame"},
    {"odometry_channel", &LcmConfig::odometry_channel, false,
     "pose and twist of the body with their covariances, for filters; empty = not sent"},
    {"delta_body_channel", &LcmConfig::delta_body_channel, false,
     "the camera's motion as the body's, e.g. VO_DELTA_BODY; empty = not sent"},
    {"images_channel", &LcmConfig::images_channel, false,
     "rectified left image, disparity and mask, e.g. VO_IMAGES; empty = not sent"},
    {"points_channel", &LcmConfig::points_channel, false,
     "points of the disparity in the body frame, with sigma, e.g. VO_POINTS; empty = not sent"},
    {"movers_channel", &LcmConfig::movers_channel, false,
     "things that move by themselves, e.g. VO_MOVERS; empty = not sent"},
    {"features_channel", &LcmConfig::features_channel, false,
     "what became of each feature and each check, e.g. VO_FEATURES; empty = not sent"},
    {"health_channel", &LcmConfig::health_channel, false, "rates, latency, drops, once a second; empty = not sent"},
};

}  // namespace cliquevo::daemon
