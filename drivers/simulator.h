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
                                  0.0};  // error of the right eye that the calibration does not know, about x y z
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
  // what goes wrong: none, blank, noise (both images), frozen (right eye), covered (left eye), flare, night
  std::string fault = "none";
  std::int64_t fault_first = 0;    // frame of the render
  std::int64_t fault_frames = -1;  // how many, -1 = to the end
  // sensor
  std::uint64_t noise_seed = 1;
  double noise_sigma = 2.0;  // grey levels, read noise
  bool shot_noise = true;
  bool motion_blur = true;
  bool exposure_changes = true;
  // store
  std::string cache_dir;  // noise-free renders are kept here; empty = $CLIQUEVO_CACHE, else ~/.cache/cliquevo; "none" =
                          // no cache
  double cache_limit_gb = 12.0;  // of all scenes together; the ones not used for longest go first
  int workers = 0;               // render threads, 0 = all cores

  Result<void> check() const;
};

class Simulator : public FrameSource {
 public:
  // Exact disparity of the last pair's rectified left image, px; NaN where there is none.
  virtual ImageView<const float> truth_disparity() const = 0;
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
