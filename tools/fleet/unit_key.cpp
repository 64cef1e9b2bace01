// SPDX-License-Identifier: BSD-3-Clause
#include "tools/fleet/unit_key.h"

#include <algorithm>
#include <array>
#include <string_view>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "tools/fleet/digest.h"
#include "tools/fleet/fingerprint.h"
#include "tools/reference.h"
#include "tools/source_argument.h"

namespace cliquevo::tools::fleet {

namespace {

constexpr int kResultVersion = 1;  // another number when a result holds other things than before: no key is then known

template <typename Derived>
std::string numbers(const Eigen::DenseBase<Derived>& values) {
  std::string out;
  for (Eigen::Index i = 0; i < values.rows(); ++i) {
    for (Eigen::Index j = 0; j < values.cols(); ++j) out += fmt::format("{} ", values(i, j));
  }
  return out;
}

std::string camera_text(const CameraCalibration& c) {
  return fmt::format("{} {} {} {} {} {} {} {} {}", c.width, c.height, c.fx_px, c.fy_px, c.cx_px, c.cy_px,
                     static_cast<int>(c.distortion), fmt::join(c.coefficients, " "), fmt::join(c.prism, " "));
}

std::string model_text(const StereoModel& m) {
  return fmt::format("{} {} {} {} {} {} {} {} {}", m.width, m.height, m.fx_px, m.fy_px, m.cx_px, m.cy_px, m.baseline_m,
                     m.doffs_px, m.readout_s);
}

void add_calibration(Digest& digest, const StereoCalibration& c) {
  digest.field("left", camera_text(c.left)).field("right", camera_text(c.right));
  digest.field("turn", numbers(c.T_right_left.R)).field("baseline", numbers(c.T_right_left.t));
  digest.field("readout", fmt::format("{}", c.readout_s)).field("rectified", c.rectified ? "yes" : "no");
  if (!c.prescribed) return;
  digest.field("prescribed", model_text(c.prescribed->model));
  digest.field("rectification", numbers(c.prescribed->R_left) + numbers(c.prescribed->R_right));
}

void add_mask(Digest& digest, const char* name, const Image<std::uint8_t>& mask) {
  Digest pixels;
  for (int j = 0; j < mask.height(); ++j) {
    pixels.add({reinterpret_cast<const char*>(mask.cview().row(j)), static_cast<std::size_t>(mask.width())});
  }
  digest.field(name, fmt::format("{} {} {}", mask.width(), mask.height(), pixels.hex()));
}

// Of the simulator: where renders are kept, and by how many threads they are made, is in no picture.
bool without_effect(std::string_view key) {
  return key == "stereo.workers" || key == "source.simulator.cache_dir" || key == "source.simulator.cache_limit_gb" ||
         key == "source.simulator.workers" ||
         // what these name is hashed itself
         key == "source.recording.path" || key == "source.recording.calibration" ||
         key == "source.recording.left_mask" || key == "source.recording.right_mask";
}

std::string keys_below(const daemon::Config& config, std::initializer_list<std::string_view> sections) {
  std::string out;
  for (const auto& key : daemon::list_config(config)) {
    const std::string& name = key.first;
    const auto in = [&name](std::string_view section) { return name.starts_with(section); };
    if (std::any_of(sections.begin(), sections.end(), in) && !without_effect(name)) {
      out += fmt::format("{}={}\n", name, key.second);
    }
  }
  return out;
}

}  // namespace

Result<std::unique_ptr<drivers::FrameSource>> open_unit_source(const std::string& source,
                                                               const daemon::Config& config) {
  SourceArgument argument;
  argument.text = source;
  argument.print_notes = false;
  if (auto usable = check_source(argument); !usable) return usable.error();
  daemon::SourceConfig reading = config.source;
  reading.recording.read_ahead = false;  // there are as many units at once as processors
  reading.simulator.workers = 1;
  return open_source(argument, reading);
}

std::string reading_text(const daemon::Config& config) {
  return keys_below(config, {"source.recording.", "source.simulator.", "source.swap_eyes"}) +
         config.source.recording.calibration + "\n" + config.source.recording.left_mask + "\n" +
         config.source.recording.right_mask;
}

Result<SourceIdentity> identify_simulated(const std::string& source, const daemon::Config& config) {
  daemon::Config rendered = config;
  if (source != "sim") {
    const auto options = drivers::parse_simulator_options(source.substr(4));
    if (!options) return options.error();
    rendered.source.simulator = *options;
  }
  const drivers::SimulatorOptions& options = rendered.source.simulator;
  if (auto usable = options.check(); !usable) return usable.error();
  SourceIdentity out;
  out.digest = Digest().field("simulator", keys_below(rendered, {"source.simulator.", "source.swap_eyes"})).hex();
  out.frames = (options.frames + options.every - 1) / options.every;
  return out;
}

Result<SourceIdentity> identify(const std::string& source, const daemon::Config& config,
                                const drivers::SourceInfo& opened) {
  if (is_simulator(source)) return identify_simulated(source, config);
  const auto content = fingerprint_of(source);
  if (!content) return content.error();
  Digest digest;
  digest.field("content", content->digest);
  digest.field("reading", keys_below(config, {"source.recording.", "source.swap_eyes"}));
  digest.field("size", fmt::format("{} {}", opened.width, opened.height));
  add_calibration(digest, opened.calibration);
  add_mask(digest, "left_mask", opened.left_mask);
  add_mask(digest, "right_mask", opened.right_mask);
  // It may lie outside the recording's folder.
  if (const std::string reference = reference_beside(source); !reference.empty()) {
    const auto truth = fingerprint_of(reference);
    if (!truth) return truth.error();
    digest.field("reference", truth->digest);
  }
  return SourceIdentity{digest.hex(), opened.frame_count, content->bytes};
}

std::string unit_key(const std::string& build, const daemon::Config& config, const SourceIdentity& source,
                     bool trajectory) {
  Digest digest;
  digest.field("unit", fmt::format("{}", kResultVersion)).field("build", build).field("source", source.digest);
  digest.field("configuration", keys_below(config, {"rectify.", "stereo.", "odometry."}));
  digest.field("trajectory", trajectory ? "kept" : "not kept");
  return digest.hex();
}

}  // namespace cliquevo::tools::fleet
