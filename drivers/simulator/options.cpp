// SPDX-License-Identifier: BSD-3-Clause
#include <charconv>
#include <cmath>
#include <string_view>
#include <type_traits>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "drivers/board_calibration/board.h"
#include "drivers/simulator.h"
#include "drivers/simulator/board_rig.h"
#include "drivers/simulator/camera_sets.h"

namespace cliquevo::drivers {

namespace {

template <typename T>
bool parse_number(std::string_view text, T& value) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  return error == std::errc{} && end == text.data() + text.size();
}

bool parse_value(std::string_view text, bool& value) {
  if (text == "true" || text == "yes" || text == "on" || text == "1") {
    value = true;
  } else if (text == "false" || text == "no" || text == "off" || text == "0") {
    value = false;
  } else {
    return false;
  }
  return true;
}
bool parse_value(std::string_view text, std::string& value) {
  value = text;
  return !text.empty();
}
template <typename T>
bool parse_value(std::string_view text, T& value) {
  return parse_number(text, value);
}
// Three angles: x:y:z
bool parse_value(std::string_view text, double (&value)[3]) {
  for (int k = 0; k < 3; ++k) {
    const std::size_t colon = text.find(':');
    if ((colon == std::string_view::npos) != (k == 2)) return false;
    if (!parse_number(text.substr(0, colon), value[k])) return false;
    if (k < 2) text.remove_prefix(colon + 1);
  }
  return true;
}

struct Key {
  const char* name;
  const char* meaning;
  bool on_off;
  bool (*set)(SimulatorOptions&, std::string_view);
};

#define CLIQUEVO_OPTION(NAME, MEANING)                                                  \
  {                                                                                     \
#NAME, MEANING, std::is_same_v < decltype(SimulatorOptions::NAME), bool>,           \
        [](SimulatorOptions & o, std::string_view v) { return parse_value(v, o.NAME); } \
  }
constexpr Key kKeys[] = {
    CLIQUEVO_OPTION(course, "wheeled, walking, standing, straight, turn (pure rotation)"),
    CLIQUEVO_OPTION(frames, "length of the render, frames at rate_hz"),
    CLIQUEVO_OPTION(every, "deliver every k-th frame of it"),
    CLIQUEVO_OPTION(step_m, "way from frame to frame, m"),
    CLIQUEVO_OPTION(rate_hz, "frames a second of the render"),
    CLIQUEVO_OPTION(width, "px"),
    CLIQUEVO_OPTION(height, "px"),
    CLIQUEVO_OPTION(focal_px, "focal length, px"),
    CLIQUEVO_OPTION(baseline_m, "between the cameras, m"),
    CLIQUEVO_OPTION(camera_height_m, "above ground, m"),
    CLIQUEVO_OPTION(pitch_deg, "negative looks down"),
    CLIQUEVO_OPTION(raw, "distorted, misaligned pair as grabbed, with its calibration"),
    CLIQUEVO_OPTION(misalign_right_deg, "turn of the right camera that the calibration does not know, x:y:z"),
    CLIQUEVO_OPTION(world_seed, "another world"),
    CLIQUEVO_OPTION(rocks, "percent of the scene's own rocks, stones and posts, -1 = 100"),
    CLIQUEVO_OPTION(movers, "number of boxes that drive about"),
    CLIQUEVO_OPTION(shadow, "the robot's own shadow"),
    CLIQUEVO_OPTION(scene, "natural, water (drifting texture), lorry (a mover fills most of the view)"),
    CLIQUEVO_OPTION(railings, "a railing of even bars on the left of the way"),
    CLIQUEVO_OPTION(walls, "a brick wall on the right of the way"),
    CLIQUEVO_OPTION(glass, "glass panes on the right of the way, which mirror something far away"),
    CLIQUEVO_OPTION(fault, "none, blank, noise, frozen, covered, flare, night"),
    CLIQUEVO_OPTION(fault_first, "frame at which the fault begins"),
    CLIQUEVO_OPTION(fault_frames, "how many frames it lasts, -1 = to the end"),
    CLIQUEVO_OPTION(noise_seed, "other noise over the same render"),
    CLIQUEVO_OPTION(noise_sigma, "read noise, grey levels"),
    CLIQUEVO_OPTION(shot_noise, "noise that grows with the light"),
    CLIQUEVO_OPTION(motion_blur, "3 ms of exposure"),
    CLIQUEVO_OPTION(exposure_changes, "drift and steps of the exposure"),
    {"camera", "clean, webcam, flexing, vibrating, action, sun: a set of what follows, with its size and focal length",
     false,
     [](SimulatorOptions& o, std::string_view v) {
       const bool known = sim::is_camera_set(std::string(v));
       if (known) o.camera = v;
       if (known) sim::take_camera_size(o);
       return known;
     }},
    CLIQUEVO_OPTION(jpeg_quality, "1 (worst) to 100, 0 = not compressed, -1 = the camera's own"),
    CLIQUEVO_OPTION(jpeg_spread, "each picture's quality is off by up to so much, -1 = the camera's own"),
    CLIQUEVO_OPTION(defocus_px, "Gaussian blur, sigma, px, -1 = the camera's own"),
    CLIQUEVO_OPTION(vibration_px,
                    "longest blur by both cameras shaking, px, another in each frame, -1 = the camera's own"),
    CLIQUEVO_OPTION(readout_ms, "rolling shutter, from the first row to the last, ms, -1 = the camera's own"),
    CLIQUEVO_OPTION(shake_px,
                    "right camera shaking: common disparity error of a frame, sigma, px, -1 = the camera's own"),
    CLIQUEVO_OPTION(shake_rows_px, "and row error, sigma, px, -1 = the camera's own"),
    CLIQUEVO_OPTION(shake_hz, "how fast it shakes, Hz"),
    CLIQUEVO_OPTION(sun_contrast, "hard sun: times the contrast, burnt out and black beyond it, -1 = the camera's own"),
    CLIQUEVO_OPTION(right_gain, "right camera's grey levels, times, -1 = the camera's own"),
    CLIQUEVO_OPTION(right_gamma, "to the power of, -1 = the camera's own"),
    CLIQUEVO_OPTION(right_bias, "plus, grey levels, -1 = the camera's own"),
    CLIQUEVO_OPTION(sway_deg, "further turning of the camera, sigma, degrees, -1 = the camera's own"),
    CLIQUEVO_OPTION(board, "a calibration board moved before the cameras, KIND:COLSxROWS:SIZE_M, instead of a course"),
    CLIQUEVO_OPTION(lens, "of the cameras before a board: none, plumb_bob, rational, equidistant"),
    CLIQUEVO_OPTION(rig_seed, "of the cameras before a board: 0 = mounted as the raw pair, others = at random"),
    CLIQUEVO_OPTION(skew_ms, "how much later the right camera before a board exposes, ms"),
    CLIQUEVO_OPTION(board_hold_s, "how long the board is held in a place, s; 0 = in each frame another place"),
    CLIQUEVO_OPTION(board_move_s, "how long it takes to the next place, s"),
    CLIQUEVO_OPTION(cache_dir, "where renders are kept; none = nowhere"),
    CLIQUEVO_OPTION(cache_limit_gb, "size of the store, GB; what was not used for longest goes"),
    CLIQUEVO_OPTION(workers, "render threads, 0 = all cores"),
};
#undef CLIQUEVO_OPTION

constexpr const char* kScenes[] = {"natural", "water", "lorry"};
constexpr const char* kFaults[] = {"none", "blank", "noise", "frozen", "covered", "flare", "night"};
constexpr const char* kCourses[] = {"wheeled", "walking", "standing", "straight", "turn"};

Error bad(const std::string& where, const std::string& remedy) { return {"bad simulator option", where, remedy}; }

template <std::size_t kCount>
Result<void> one_of(const char* name, const std::string& value, const char* const (&known)[kCount]) {
  for (const char* k : known)
    if (value == k) return {};
  return bad(fmt::format("{} = {}", name, value), fmt::format("use one of {}", fmt::join(known, ", ")));
}

// What belongs to a board alone.
Result<void> check_board(const SimulatorOptions& o) {
  if (!o.lens.empty() && !sim::is_lens_name(o.lens)) {
    return bad("lens = " + o.lens, "use one of none, plumb_bob, rational, equidistant");
  }
  if (o.board.empty()) {
    const bool alone = o.lens.empty() && o.rig_seed == 0 && o.skew_ms == 0.0;
    return alone ? Result<void>() : bad("lens, rig_seed or skew_ms", "name a board: they are not for courses");
  }
  if (auto board = calibration::parse_board(o.board); !board) return board.error();
  for (const double turn : o.misalign_right_deg) {
    if (turn != 0.0) return bad("misalign_right_deg with a board", "use rig_seed for another mount");
  }
  return {};
}

}  // namespace

Result<void> SimulatorOptions::check() const {
  const auto in = [](double v, double low, double high) { return std::isfinite(v) && v >= low && v <= high; };
  struct Range {
    const char* name;
    double value, low, high;
  };
  const Range ranges[] = {
      {"width", static_cast<double>(width), 64, 4096},
      {"height", static_cast<double>(height), 48, 4096},
      {"focal_px", focal_px, 0.3 * width, 20.0 * width},
      {"baseline_m", baseline_m, 0.01, 2.0},
      {"camera_height_m", camera_height_m, 0.2, 10.0},
      {"pitch_deg", pitch_deg, -80.0, 45.0},
      {"misalign_right_deg x", misalign_right_deg[0], -5.0, 5.0},
      {"misalign_right_deg y", misalign_right_deg[1], -5.0, 5.0},
      {"misalign_right_deg z", misalign_right_deg[2], -5.0, 5.0},
      {"frames", static_cast<double>(frames), 1, 1e6},
      {"step_m", step_m, 0.0, 2.0},
      {"rate_hz", rate_hz, 1.0, 1000.0},
      {"every", static_cast<double>(every), 1, 1000},
      {"rocks", static_cast<double>(rocks), -1, 1000},
      {"movers", static_cast<double>(movers), 0, 50},
      {"fault_first", static_cast<double>(fault_first), 0, 1e6},
      {"fault_frames", static_cast<double>(fault_frames), -1, 1e6},
      {"noise_sigma", noise_sigma, 0.0, 100.0},
      {"jpeg_quality", static_cast<double>(jpeg_quality), -1, 100},
      {"jpeg_spread", static_cast<double>(jpeg_spread), -1, 50},
      {"defocus_px", defocus_px, -1.0, 8.0},
      {"vibration_px", vibration_px, -1.0, 60.0},
      {"readout_ms", readout_ms, -1.0, 100.0},
      {"shake_px", shake_px, -1.0, 10.0},
      {"shake_rows_px", shake_rows_px, -1.0, 10.0},
      {"shake_hz", shake_hz, 0.01, 1000.0},
      {"sun_contrast", sun_contrast, -1.0, 20.0},
      {"right_gain", right_gain, -1.0, 4.0},
      {"right_gamma", right_gamma, -1.0, 4.0},
      {"right_bias", right_bias, -1.0, 100.0},
      {"sway_deg", sway_deg, -1.0, 10.0},
      {"skew_ms", skew_ms, -100.0, 100.0},
      {"board_hold_s", board_hold_s, 0.0, 60.0},
      {"board_move_s", board_move_s, 0.0, 60.0},
      {"cache_limit_gb", cache_limit_gb, 0.0, 1e5},
      {"workers", static_cast<double>(workers), 0, 256},
  };
  for (const Range& r : ranges) {
    if (!in(r.value, r.low, r.high))
      return bad(fmt::format("{} = {}", r.name, r.value), fmt::format("use a value from {} to {}", r.low, r.high));
  }
  if (auto ok = one_of("course", course, kCourses); !ok) return ok;
  if (auto ok = one_of("scene", scene, kScenes); !ok) return ok;
  if (auto ok = one_of("fault", fault, kFaults); !ok) return ok;
  if (!sim::is_camera_set(camera)) return bad("camera = " + camera, "use one of " + sim::camera_set_names());
  if (course == "straight" && step_m * static_cast<double>(frames) > 5000.0) {
    return bad(fmt::format("straight course of {} m", step_m * static_cast<double>(frames)),
               "use at most 5000 m, or the wheeled course, which has no end");
  }
  if (auto ok = check_board(*this); !ok) return ok;
  // The lens of the raw pair is monotonic up to there.
  const bool raw_lens = rig_seed == 0 && (lens == "plumb_bob" || (lens.empty() && raw));
  if (raw_lens && focal_px < 0.7 * std::hypot(width, height)) {
    return bad(fmt::format("focal_px = {} with raw", focal_px),
               fmt::format("use at least {:.0f}: the raw lens does not reach further out",
                           std::ceil(0.7 * std::hypot(width, height))));
  }
  return {};
}

const std::vector<SimulatorKey>& simulator_keys() {
  static const std::vector<SimulatorKey> kList = [] {
    std::vector<SimulatorKey> list;
    for (const Key& key : kKeys) list.push_back({key.name, key.meaning, key.on_off});
    return list;
  }();
  return kList;
}

Result<void> set_simulator_option(SimulatorOptions& options, const std::string& name, const std::string& value) {
  for (const Key& key : kKeys) {
    if (name != key.name) continue;
    if (key.set(options, value)) return {};
    return bad(fmt::format("{} = '{}'", name, value),
               key.on_off ? "use on or off" : fmt::format("{} ({})", "give a value of its type", key.meaning));
  }
  std::string names;
  for (const Key& key : kKeys) names += (names.empty() ? "" : ", ") + std::string(key.name);
  return bad(fmt::format("unknown key '{}'", name), "use one of " + names);
}

namespace {

// The key "camera" alone, or all others.
Result<void> set_all(SimulatorOptions& options, const std::string& text, bool camera) {
  std::string_view rest = text;
  while (!rest.empty()) {
    const std::size_t comma = rest.find(',');
    const std::string_view item = rest.substr(0, comma);
    rest.remove_prefix(comma == std::string_view::npos ? rest.size() : comma + 1);
    if (item.empty()) continue;
    const std::size_t equals = item.find('=');
    const std::string key(item.substr(0, equals));
    const std::string value(equals == std::string_view::npos ? std::string_view() : item.substr(equals + 1));
    if ((key == "camera") != camera) continue;
    if (auto set = set_simulator_option(options, key, value); !set) return set.error();
  }
  return {};
}

}  // namespace

Result<SimulatorOptions> parse_simulator_options(const std::string& text) {
  SimulatorOptions options;
  // The camera first: whatever else is given overrides its set, in any order.
  for (const bool camera : {true, false})
    if (auto set = set_all(options, text, camera); !set) return set.error();
  if (const Result<void> checked = options.check(); !checked) return checked.error();
  return options;
}

}  // namespace cliquevo::drivers
