// SPDX-License-Identifier: BSD-3-Clause
// A stereo camera in a rendered world with exact truth: pose and disparity of every frame. Deterministic by seed.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/camera_model.h"
#include "drivers/frame_source.h"

namespace cliquevo::drivers {

// Defaults are the reference scene.
struct SimulatorOptions {
  // camera
  int width = 512;
  int height = 384;
  double focal_px = 560.0;
  double baseline_m = 0.12;
  double camera_height_m = 0.85;
  double pitch_deg = -13.0;  // negative looks down
  bool raw = false;          // distorted, misaligned pair as grabbed, with its calibration
  double misalign_right_deg[3] = {0.0, 0.0,
                                  0.0};  // error of the right camera that the calibration does not know, about x y z
  // course
  std::string course = "wheeled";  // wheeled, walking, standing, straight, turn (pure rotation)
  std::int64_t frames = 200;
  double step_m = 0.1;  // way from frame to frame at rate_hz
  double rate_hz = 30.0;
  std::int64_t every = 1;  // every k-th frame of the render
  // world
  std::uint64_t world_seed = 1;
  int rocks = -1;                 // percent of the scene's own number, -1 = 100
  int movers = 0;                 // independently moving objects
  bool shadow = false;            // the robot's own shadow, moving with it
  std::string scene = "natural";  // natural; water: the ground's texture drifts; lorry: a mover fills most of the view
  bool railings = false;          // even bars on the left of the way, without end
  bool walls = false;             // a brick wall on its right
  bool glass = false;             // panes there, which mirror something far away; the truth is the pane
  // what goes wrong: none, blank, noise (both images), frozen (right camera), covered (left camera), flare, night
  std::string fault = "none";
  std::int64_t fault_first = 0;    // frame of the render
  std::int64_t fault_frames = -1;  // how many, -1 = to the end
  // sensor
  std::uint64_t noise_seed = 1;
  double noise_sigma = 2.0;  // grey levels, read noise
  bool shot_noise = true;
  bool motion_blur = true;
  bool exposure_changes = true;
  // rough cameras: a set by name, and its effects one by one; -1 = as the set has it
  std::string camera = "clean";  // clean, webcam, flexing, vibrating, action, sun
  int jpeg_quality = -1;         // 1 (worst) to 100, 0 = not compressed
  int jpeg_spread = -1;          // each picture's quality is off by up to so much
  double defocus_px = -1.0;      // sigma of a Gaussian
  double vibration_px = -1.0;    // longest blur of both cameras by shaking together, another in each frame
  double readout_ms = -1.0;      // rolling shutter: from the first row to the last; 0 = all rows at once
  double shake_px = -1.0;        // right camera on its mount: sigma of the disparity error that a frame has everywhere
  double shake_rows_px = -1.0;   // and of the row error
  double shake_hz = 15.0;        // how fast it shakes
  double sun_contrast = -1.0;    // hard sun: contrast about a middle grey, with burnt-out and black parts; 1 = none
  double right_gain = -1.0;      // response of the right camera beside the left one's: times,
  double right_gamma = -1.0;     // to the power of,
  double right_bias = -1.0;      // plus grey levels
  double sway_deg = -1.0;        // further turning of the camera about all axes, sigma; part of the true motion
  // a calibration board that is moved before cameras that stand still, instead of a course
  std::string board;           // KIND:COLSxROWS:SIZE_M as `cliquevo calibrate` takes it; empty = none
  std::string lens;            // none, plumb_bob, rational, equidistant; empty: with raw plumb_bob, else none
  std::uint64_t rig_seed = 0;  // 0 = the mount and lenses of the courses' raw pair; others: rigs at random
  double skew_ms = 0.0;        // how much later the right camera exposes
  double board_hold_s = 0.7;   // how long it is held in a place; 0 = in each frame another place
  double board_move_s = 0.6;   // how long it takes to the next
  // store
  std::string cache_dir;  // noise-free renders are kept here; empty = $CLIQUEVO_CACHE, else ~/.cache/cliquevo; "none" =
                          // no cache
  double cache_limit_gb = 12.0;  // of all scenes together; the ones not used for longest go first
  int workers = 0;               // render threads, 0 = all cores

  Result<void> check() const;
};

// Of a right camera that shakes on its mount: what is added to every disparity of a frame, and to every row in the
// right picture.
struct CameraShake {
  double disparity_px = 0.0;
  double rows_px = 0.0;
};

class Simulator : public FrameSource {
 public:
  // Exact disparity of the last pair's rectified left image, px; NaN where there is none. Of the camera without shake.
  virtual ImageView<const float> truth_disparity() const = 0;
  virtual CameraShake truth_shake() const = 0;
};

Result<std::unique_ptr<Simulator>> open_simulator(const SimulatorOptions& options);

// The keys of SimulatorOptions, for texts and command lines. A value is text: numbers, on/off, angles as x:y:z.
struct SimulatorKey {
  std::string name;
  std::string meaning;  // with unit
  bool on_off;
};
const std::vector<SimulatorKey>& simulator_keys();
// An error names the key and what it takes; check() is the caller's.
Result<void> set_simulator_option(SimulatorOptions& options, const std::string& key, const std::string& value);

// Parses "key=value,key=value" (keys as above) for SOURCE arguments of the form sim:course=walking,frames=400.
Result<SimulatorOptions> parse_simulator_options(const std::string& text);

}  // namespace cliquevo::drivers
