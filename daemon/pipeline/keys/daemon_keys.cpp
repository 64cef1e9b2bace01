// SPDX-License-Identifier: BSD-3-Clause
#include "core/rt/handover.h"
#include "daemon/pipeline/keys/keys.h"

namespace cliquevo::daemon {

namespace {

void add_lcm_keys(LcmConfig& lcm, KeyTable& t) {
  t.section("lcm", "messages: what is sent, where to, and commands");
  t.text("url", lcm.url, "ttl=0 stays on this machine");
  for (const LcmChannel& channel : kLcmChannels) {
    t.text(channel.key, lcm.*channel.name, channel.meaning, between(channel.required ? 1 : 0, kLongestChannel));
  }
  t.number("images_rate_hz", lcm.images_rate_hz, "Hz", between(0.01, 1000), "so many pictures a second at most")
      .reloadable = true;
  t.flag("images_right", lcm.images_right, "with each the rectified right image, behind the other two");
  t.number("points_rate_hz", lcm.points_rate_hz, "Hz", between(0.01, 1000), "so many sets of points a second at most")
      .reloadable = true;
  t.number("points_step_px", lcm.points_step_px, "px", between(1, 64), "one point a square of this side");
  t.group(
      "Commands by message: whoever can send to the group can then reset the pose and fill the disk with recordings. "
      "With ttl=0 that is every program and user of this machine, with more every machine that is reached. The control "
      "socket below is for its owner and group alone: prefer it.");
  t.text("command_channel", lcm.command_channel, "commands are received here, e.g. VO_COMMAND; empty = none are",
         between(0, kLongestChannel));
}

void add_realtime_keys(RealtimeConfig& realtime, KeyTable& t) {
  t.section("realtime", "of the daemon; rights that it lacks are reported once, and it runs without");
  t.flag("lock_memory", realtime.lock_memory, "keep all memory in RAM");
  t.number("stereo_cpu", realtime.stereo_cpu, "", between(-1, 1023), "core that the stereo thread stays on; -1 = any");
  t.number("odometry_cpu", realtime.odometry_cpu, "", between(-1, 1023), "the same for the odometry thread");
  t.number("worker_cpu", realtime.worker_cpu, "", between(-1, 1023),
           "the same for stereo's second worker (stereo.workers); further ones take the cores after it");
  t.number("stereo_priority", realtime.stereo_priority, "", between(0, 99),
           "SCHED_FIFO priority of the stereo thread; 0 = ordinary time sharing");
  t.number("odometry_priority", realtime.odometry_priority, "", between(0, 99), "the same for the odometry thread");
  t.number("output_priority", realtime.output_priority, "", between(0, 99),
           "of the thread that sends the messages: it may block in the kernel, so below the others");
  t.number("catch_up_frames", realtime.catch_up_frames, "", between(0, rt::Handover::kMostBacklog),
           "frames that may wait while a hiccup is caught up with (all in 256 MB); 0 = always the newest");
}

void add_recording_keys(RecordingConfig& recording, KeyTable& t) {
  t.section("recording", "of the daemon: LCM event logs of pairs (as grabbed), calibration and the messages sent");
  t.file("folder", recording.folder, "where to; empty = none are written").reloadable = true;
  t.flag("at_start", recording.at_start, "from the start on; false = on command (cliquevo ctl record-start)");
  t.number("max_file_mb", recording.max_file_mb, "MB", between(1, 1e6), "a new file when this one has so much")
      .reloadable = true;
  t.number("max_total_mb", recording.max_total_mb, "MB", between(2, 1e8),
           "of all logs the daemon wrote into the folder: the oldest are removed")
      .reloadable = true;
  t.number("queue_mb", recording.queue_mb, "MB", between(1, 4096),
           "memory for what waits for the disk; pairs beyond are left out and counted")
      .reloadable = true;
}

}  // namespace

void add_daemon_keys(Config& config, KeyTable& t) {
  add_lcm_keys(config.lcm, t);

  t.section("control", "commands to the running daemon");
  t.file("socket", config.control.socket, "of `cliquevo ctl`; for the daemon's user and group; empty = none");

  add_realtime_keys(config.realtime, t);
  add_recording_keys(config.recording, t);

  t.section("body", "how the rectified left camera sits on the vehicle (X forward, Y left, Z up)");
  t.triple("translation_m", config.body.translation_m, "m", any(), "camera in the body frame");
  t.triple("roll_pitch_yaw_deg", config.body.roll_pitch_yaw_deg, "deg", any(),
           "0 = level, forward; about X, then Y, then Z; pitch > 0 looks down");

  t.section("log", "what the daemon writes to the journal or stderr");
  t.choice("level", config.log_level, {"trace", "debug", "info", "warn", "error"}, "least level that is written")
      .reloadable = true;
}

}  // namespace cliquevo::daemon
