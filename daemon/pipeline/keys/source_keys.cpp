// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/camera_families.h"
#include "daemon/pipeline/keys/keys.h"

namespace cliquevo::daemon {

namespace {

std::vector<std::string> source_types() {
  std::vector<std::string> out{"simulator", "recording"};
  for (const CameraFamily& family : camera_families()) out.emplace_back(family.name);
  return out;
}

// What both recordings and cameras say of their calibration.
void add_calibration_options(drivers::CalibrationOptions& options, KeyTable& t) {
  t.number("baseline_unit", options.baseline_unit_m, "m", between(0, 1e6),
           "metres a unit of its lengths, e.g. 0.025 for squares of 25 mm; 0 = the format's own");
  t.flag("rectified", options.rectified, "whether the images are rectified by this calibration already");
  t.text("lens", options.lens,
         "of four distortion terms without a name: plumb_bob or equidistant; empty = judged by the numbers");
  t.number("readout_ms", options.readout_ms, "ms", between(0, 1000),
           "rolling shutter: time from the first row's exposure to the last one's; 0 = all rows at once");
}

void add_recording_keys(drivers::RecordingOptions& recording, KeyTable& t) {
  t.section("source.recording", "pairs from disk");
  t.file("path", recording.path,
         "folder (drivers/README.md lists the layouts), LCM event log, bag (.mcap, .bag, .db3) or video");
  t.file("calibration", recording.calibration, "file or folder; empty = the recording's own");
  add_calibration_options(recording.calibration_options, t);
  t.number("rate_hz", recording.rate_hz, "Hz", above(0),
           "pairs a second, whatever times are there; auto = from the recording");
  t.number("first", recording.first, "", at_least(0), "first pair to play, counted from 0");
  t.number("last", recording.last, "", at_least(-1), "last pair to play; -1 = the last there is");
  t.number("every", recording.every, "", at_least(1), "play every k-th pair");
  t.number("pair_tolerance_s", recording.pair_tolerance_s, "s", at_least(0),
           "longest time between the two images of a pair; auto = a quarter period");
  t.flag("side_by_side", recording.side_by_side,
         "each image holds both cameras' pictures, left half and right half; detected where the halves match");
  t.text("channel", recording.channel, "of a log; empty = the only one with stereo pairs");
  t.text("topics", recording.topics,
         "of a bag: LEFT,RIGHT or LEFT,RIGHT,LEFT_INFO,RIGHT_INFO; empty = by types and names");
  t.file("left_mask", recording.left_mask,
         "image, 0 = the vehicle's own parts; empty = the recording's mask_left.png where there is one");
  t.file("right_mask", recording.right_mask, "the same for the right camera, mask_right.png");
  using drivers::Bayer;
  t.choice("bayer", recording.bayer,
           {{"auto", Bayer::automatic},
            {"none", Bayer::none},
            {"rggb", Bayer::rggb},
            {"bggr", Bayer::bggr},
            {"grbg", Bayer::grbg},
            {"gbrg", Bayer::gbrg}},
           "raw Bayer mosaics become grey; auto = where the images show it");
}

void add_camera_image_keys(drivers::CameraOptions& cameras, KeyTable& t) {
  t.number("rate_hz", cameras.rate_hz, "Hz", between(0.1, 1000), "frames a second");
  t.number("width", cameras.width, "px", between(0, 16384), "of one camera's image; 0 = as the camera is set");
  t.number("height", cameras.height, "px", between(0, 16384), "of one camera's image; 0 = as the camera is set");
  t.number("offset_x", cameras.offset_x, "px", between(0, 16384), "aravis: where the region of interest begins");
  t.number("offset_y", cameras.offset_y, "px", between(0, 16384), "aravis: where the region of interest begins");
  t.number("binning", cameras.binning, "px", between(1, 16), "aravis: pixels joined in both directions");
  t.text("pixel_format", cameras.pixel_format,
         "the camera's name for it (Mono12, BayerRG8; YUYV, MJPG, RGGB); empty = grey where offered");
  t.number("exposure_us", cameras.exposure_us, "us", above(0),
           "of both cameras; auto = the left camera's own control, which the right one follows");
  t.number("exposure_max_us", cameras.exposure_max_us, "us", between(0, 1e7),
           "limit of the automatic exposure time, against motion blur: the gain makes up for it; 0 = none");
  t.number("gain", cameras.gain, "", any(), "of both cameras, in the camera's unit; auto = as exposure_us");
}

void add_camera_keys(drivers::CameraOptions& cameras, KeyTable& t) {
  t.section("source.cameras", "a live pair; `cliquevo cameras` lists what there is, with the lines that select it");
  t.text("left", cameras.left,
         "aravis: serial number or address; v4l2: path, best from /dev/v4l/by-id; libcamera: id; waited for");
  t.text("right", cameras.right, "the right camera; empty where one camera delivers both pictures (layout)");
  t.file("calibration", cameras.calibration, "file or folder; must be given");
  add_calibration_options(cameras.calibration_options, t);
  add_camera_image_keys(cameras, t);
  using drivers::CameraTrigger;
  t.choice("trigger", cameras.trigger,
           {{"off", CameraTrigger::off},
            {"software", CameraTrigger::software},
            {"hardware", CameraTrigger::hardware},
            {"action", CameraTrigger::action}},
           "aravis: off = free running; action = one packet for both");
  t.text("trigger_line", cameras.trigger_line, "aravis: the camera's input for trigger: hardware");
  t.flag("shared_clock", cameras.shared_clock, "both cameras stamp by one clock (PTP): pairs from the first frame on");
  t.flag("ptp", cameras.ptp, "aravis: switch PTP on");
  t.number("packet_size", cameras.packet_size, "bytes", between(0, 65535),
           "aravis: of the stream; 0 = as large as gets through");
  t.flag("packet_resend", cameras.packet_resend, "aravis: request lost packets again");
  using drivers::CameraLayout;
  t.choice("layout", cameras.layout,
           {{"two_cameras", CameraLayout::two_cameras},
            {"side_by_side", CameraLayout::side_by_side},
            {"interleaved", CameraLayout::interleaved}},
           "v4l2, libcamera: two cameras, or one that delivers both pictures, side by side or pixel by pixel");
  t.text("controls", cameras.controls, "v4l2: further controls by name, e.g. brightness=0,power_line_frequency=1");
  t.file("left_mask", cameras.left_mask, "image, 0 = the vehicle's own parts; empty = none");
  t.file("right_mask", cameras.right_mask, "the same for the right camera");
}

}  // namespace

void add_source_keys(SourceConfig& source, KeyTable& t) {
  t.section("source", "where pairs come from");
  t.choice("type", source.type, source_types(), "simulator, recording, or the family of the cameras");
  t.choice("loop", source.loop, {"none", "pingpong"},
           "none = stop at the end; pingpong = forward, backward, forward ... without end");
  t.number("speed", source.speed, "", at_least(0), "times the recorded pace; 0 = as fast as possible");
  t.flag("swap_eyes", source.swap_eyes, "left and right come exchanged, in files or cabling: put them right");
  add_recording_keys(source.recording, t);
  add_camera_keys(source.cameras, t);
}

}  // namespace cliquevo::daemon
