// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/camera_sets.h"

namespace cliquevo::drivers::sim {

namespace {

struct CameraSet {
  const char* name;
  int width = 512, height = 384;
  double focal_px = 560.0;
  int jpeg_quality = 0, jpeg_spread = 0;
  double defocus_px = 0.0, vibration_px = 0.0, readout_ms = 0.0;
  double shake_px = 0.0, shake_rows_px = 0.0;
  double sun_contrast = 1.0;
  double right_gain = 1.0, right_gamma = 1.0, right_bias = 0.0;
  double sway_deg = 0.0;
};

constexpr CameraSet kSets[] = {
    {.name = "clean"},
    // A cheap pair of web cameras: small, compressed hard, not quite in focus, rows read out one after the other.
    {.name = "webcam",
     .width = 320,
     .height = 240,
     .focal_px = 350.0,
     .jpeg_quality = 70,
     .jpeg_spread = 10,
     .defocus_px = 0.8,
     .vibration_px = 3.0,
     .readout_ms = 8.0},
    // A pair on a mount that is not stiff, on a cobbled road.
    {.name = "flexing",
     .vibration_px = 1.0,
     .shake_px = 1.2,
     .shake_rows_px = 0.3,
     .right_gain = 1.06,
     .right_bias = 2},
    // On a drone or in the hand: both cameras shake together, in each exposure another way.
    {.name = "vibrating", .vibration_px = 5.0, .sway_deg = 0.5},
    // Worn on the body: wide, rolling shutter, compressed, thrown about.
    {.name = "action",
     .focal_px = 300.0,
     .jpeg_quality = 60,
     .jpeg_spread = 10,
     .vibration_px = 3.0,
     .readout_ms = 16.0,
     .sway_deg = 2.0},
    // Against hard sunlight the one camera's exposure settles a little above the other's.
    {.name = "sun", .sun_contrast = 2.5, .right_gain = 1.12, .right_gamma = 0.92, .right_bias = 4},
};

const CameraSet* find(const std::string& name) {
  for (const CameraSet& set : kSets)
    if (name == set.name) return &set;
  return nullptr;
}

}  // namespace

bool is_camera_set(const std::string& name) { return find(name) != nullptr; }

std::string camera_set_names() {
  std::string names;
  for (const CameraSet& set : kSets) names += (names.empty() ? "" : ", ") + std::string(set.name);
  return names;
}

void take_camera_size(SimulatorOptions& o) {
  const CameraSet* set = find(o.camera);
  if (set == nullptr) return;
  o.width = set->width;
  o.height = set->height;
  o.focal_px = set->focal_px;
}

SimulatorOptions with_camera(SimulatorOptions o) {
  const CameraSet* set = find(o.camera);
  if (set == nullptr) return o;
  const auto take = [](auto& value, auto from_set) {
    if (value < 0) value = from_set;
  };
  take(o.jpeg_quality, set->jpeg_quality);
  take(o.jpeg_spread, set->jpeg_spread);
  take(o.defocus_px, set->defocus_px);
  take(o.vibration_px, set->vibration_px);
  take(o.readout_ms, set->readout_ms);
  take(o.shake_px, set->shake_px);
  take(o.shake_rows_px, set->shake_rows_px);
  take(o.sun_contrast, set->sun_contrast);
  take(o.right_gain, set->right_gain);
  take(o.right_gamma, set->right_gamma);
  take(o.right_bias, set->right_bias);
  take(o.sway_deg, set->sway_deg);
  return o;
}

}  // namespace cliquevo::drivers::sim
