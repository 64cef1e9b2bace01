// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/keys/keys.h"

namespace cliquevo::daemon {

namespace {

using drivers::SimulatorOptions;

void add_camera(SimulatorOptions& s, KeyTable& t) {
  t.number("width", s.width, "px", between(64, 4096), "of the images");
  t.number("height", s.height, "px", between(48, 4096), "of the images");
  t.number("focal_px", s.focal_px, "px", between(19.2, 81920), "focal length; 0.3 to 20 times the width");
  t.number("baseline_m", s.baseline_m, "m", between(0.01, 2), "between the cameras");
  t.number("camera_height_m", s.camera_height_m, "m", between(0.2, 10), "above ground");
  t.number("pitch_deg", s.pitch_deg, "deg", between(-80, 45), "negative looks down");
  t.flag("raw", s.raw, "a distorted, misaligned pair with its calibration instead of a rectified one");
  t.triple("misalign_right_deg", s.misalign_right_deg, "deg", between(-5, 5),
           "rotation of the right camera about x, y, z that the calibration does not know");
}

void add_course(SimulatorOptions& s, KeyTable& t) {
  t.text("course", s.course, "wheeled, walking, standing, straight, or turn (pure rotation)");
  t.number("frames", s.frames, "", between(1, 1e6), "number of pairs");
  t.number("step_m", s.step_m, "m", between(0, 2), "way from frame to frame at rate_hz");
  t.number("rate_hz", s.rate_hz, "Hz", between(1, 1000), "pairs a second");
  t.number("every", s.every, "", between(1, 1000), "play every k-th frame of the render");
}

void add_world(SimulatorOptions& s, KeyTable& t) {
  t.number("world_seed", s.world_seed, "", at_least(0), "another number is another world");
  t.number("rocks", s.rocks, "%", between(-1, 1000), "of the scene's own number of rocks and posts; -1 = 100");
  t.number("movers", s.movers, "", between(0, 50), "number of independently moving objects");
  t.flag("shadow", s.shadow, "the robot's own shadow, moving with it");
  t.text("scene", s.scene, "natural, water (drifting texture), or lorry (a mover fills most of the view)");
  t.flag("railings", s.railings, "a railing of even bars on the left of the way");
  t.flag("walls", s.walls, "a brick wall on its right");
  t.flag("glass", s.glass, "glass panes on its right, which mirror something far away");
  t.text("fault", s.fault, "none, blank, noise, frozen (right camera), covered (left camera), flare, or night");
  t.number("fault_first", s.fault_first, "", between(0, 1e6), "frame of the render at which the fault begins");
  t.number("fault_frames", s.fault_frames, "", between(-1, 1e6), "how many frames it lasts; -1 = to the end");
}

void add_sensor(SimulatorOptions& s, KeyTable& t) {
  t.number("noise_seed", s.noise_seed, "", at_least(0), "another number is other sensor noise");
  t.number("noise_sigma", s.noise_sigma, "grey levels", between(0, 100), "read noise, standard deviation");
  t.flag("shot_noise", s.shot_noise, "noise that grows with brightness");
  t.flag("motion_blur", s.motion_blur, "mild, along the motion");
  t.flag("exposure_changes", s.exposure_changes, "brightness that wanders");
}

void add_rough_camera(SimulatorOptions& s, KeyTable& t) {
  t.text("camera", s.camera,
         "clean, or rough ones: webcam, flexing, vibrating, action, sun; the keys from here on: -1 = as it says");
  t.number("jpeg_quality", s.jpeg_quality, "", between(-1, 100), "1 (worst) to 100; 0 = not compressed");
  t.number("jpeg_spread", s.jpeg_spread, "", between(-1, 50), "each picture's quality is off by up to so much");
  t.number("defocus_px", s.defocus_px, "px", between(-1, 8), "Gaussian blur, standard deviation");
  t.number("vibration_px", s.vibration_px, "px", between(-1, 60), "longest blur by both cameras shaking together");
  t.number("readout_ms", s.readout_ms, "ms", between(-1, 100), "rolling shutter, from the first row to the last");
  t.number("shake_px", s.shake_px, "px", between(-1, 10),
           "right camera shaking: disparity error common to a frame, standard deviation");
  t.number("shake_rows_px", s.shake_rows_px, "px", between(-1, 10), "and row error, standard deviation");
  t.number("shake_hz", s.shake_hz, "Hz", between(0.01, 1000), "how fast it shakes");
  t.number("sun_contrast", s.sun_contrast, "", between(-1, 20),
           "hard sun: times the contrast, burnt out and black beyond it");
  t.number("right_gain", s.right_gain, "", between(-1, 4), "right camera's grey levels: times this");
  t.number("right_gamma", s.right_gamma, "", between(-1, 4), "to the power of this");
  t.number("right_bias", s.right_bias, "grey levels", between(-1, 100), "plus this");
  t.number("sway_deg", s.sway_deg, "deg", between(-1, 10), "further turning of the camera, standard deviation");
}

void add_board(SimulatorOptions& s, KeyTable& t) {
  t.text("board", s.board, "a calibration board moved before the cameras instead of a course: KIND:COLSxROWS:SIZE_M");
  t.text("lens", s.lens, "of the cameras before a board: none, plumb_bob, rational, or equidistant");
  t.number("rig_seed", s.rig_seed, "", at_least(0),
           "of those cameras: 0 = mounted as the raw pair, others = at random");
  t.number("skew_ms", s.skew_ms, "ms", between(-100, 100), "how much later their right one exposes");
  t.number("board_hold_s", s.board_hold_s, "s", between(0, 60),
           "how long the board is held in a place; 0 = in each frame another place");
  t.number("board_move_s", s.board_move_s, "s", between(0, 60), "how long it takes to the next place");
}

}  // namespace

void add_simulator_keys(SimulatorOptions& s, KeyTable& t) {
  t.section("source.simulator", "the defaults are the reference scene");
  add_camera(s, t);
  add_course(s, t);
  add_world(s, t);
  add_sensor(s, t);
  add_rough_camera(s, t);
  add_board(s, t);
  t.text("cache_dir", s.cache_dir,
         "renders are kept here; empty = $CLIQUEVO_CACHE, else ~/.cache/cliquevo; none = keep nothing");
  t.number("cache_limit_gb", s.cache_limit_gb, "GB", between(0, 1e5),
           "of all renders together; those not used for longest go first");
  t.number("workers", s.workers, "", between(0, 256), "render threads; 0 = one a core");
}

}  // namespace cliquevo::daemon
