// SPDX-License-Identifier: BSD-3-Clause
#include "tools/simulate.h"

#include <algorithm>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "drivers/simulator.h"
#include "tools/exit_code.h"
#include "tools/output_file.h"
#include "tools/picture.h"
#include "tools/progress.h"
#include "tools/simulated_recording.h"

namespace cliquevo::tools {

namespace {

struct SimulateArguments {
  std::string out;
  std::string preview;
  std::map<std::string, std::string> values;  // by key; empty = not given
};

// A contact sheet: nine left images along the course, each with its disparity below.
class ContactSheet {
 public:
  static constexpr int kColumns = 3;
  static constexpr int kCells = 9;
  static constexpr int kCellWidth = 320;

  explicit ContactSheet(std::int64_t frames) : frames_(frames) {}

  void offer(std::int64_t index, const drivers::StereoPair& pair, ImageView<const float> disparity) {
    const auto cell = static_cast<std::int64_t>(cells_.size());
    const std::int64_t cells = std::min<std::int64_t>(kCells, frames_);
    if (cell >= cells || index < (cells > 1 ? cell * (frames_ - 1) / (cells - 1) : 0)) return;
    const auto left = pair.left.view();
    const auto far_to_near = disparity_to_file_units(disparity);
    const double nearest = 256.0 * 0.13 * left.width;
    Picture picture(left.width, 2 * left.height, {});
    for (int y = 0; y < left.height; ++y) {
      for (int x = 0; x < left.width; ++x) {
        const std::uint8_t grey = left(x, y);
        picture.set(x, y, {grey, grey, grey});
        const double near = far_to_near.cview()(x, y) / nearest;
        if (near > 0.0) picture.set(x, left.height + y, rainbow(near));
      }
    }
    cells_.push_back(picture.shrunk(kCellWidth, picture.height() * kCellWidth / picture.width()));
  }

  Picture sheet() const {
    const int rows = static_cast<int>((cells_.size() + kColumns - 1) / kColumns);
    const int height = cells_[0].height();
    Picture all(kColumns * kCellWidth, rows * height, {});
    for (std::size_t i = 0; i < cells_.size(); ++i) {
      const int at = static_cast<int>(i);
      all.put(cells_[i], at % kColumns * kCellWidth, at / kColumns * height);
    }
    return all;
  }

 private:
  std::int64_t frames_;
  std::vector<Picture> cells_;
};

Result<drivers::SimulatorOptions> to_options(const SimulateArguments& arguments) {
  drivers::SimulatorOptions options;
  // The camera first: whatever else is given overrides its set.
  for (const bool camera : {true, false}) {
    for (const auto& [key, value] : arguments.values) {
      if (value.empty() || (key == "camera") != camera) continue;
      if (auto set = drivers::set_simulator_option(options, key, value); !set) return set.error();
    }
  }
  if (auto ok = options.check(); !ok) return ok.error();
  return options;
}

int run(const SimulateArguments& arguments) {
  const auto options = to_options(arguments);
  if (!options) return report(options.error(), kWrongUsage);
  auto simulator = drivers::open_simulator(*options);
  if (!simulator) return report(simulator.error());
  drivers::Simulator& source = **simulator;
  auto recording = SimulatedRecording::create(arguments.out, source.info().calibration, source.info().rate_hz);
  if (!recording) return report(recording.error());
  std::optional<OutputFile> preview;
  if (!arguments.preview.empty()) {
    auto file = OutputFile::open(arguments.preview, "preview");
    if (!file) return report(file.error());
    preview = std::move(*file);
  }

  const std::int64_t frames = source.info().frame_count;
  ContactSheet sheet(frames);
  Progress progress(frames);
  drivers::StereoPair pair;
  double distance_m = 0.0;
  Eigen::Vector3d last = Eigen::Vector3d::Zero();
  for (std::int64_t i = 0;; ++i) {
    const auto more = source.next(pair);
    if (!more) return report(more.error());
    if (!*more) break;
    const auto disparity = source.truth_disparity();
    if (auto ok = recording->add(pair, disparity); !ok) return report(ok.error());
    if (preview) sheet.offer(i, pair, disparity);
    distance_m += (pair.truth_T_world_camera->t - last).norm();
    last = pair.truth_T_world_camera->t;
    progress.update(i + 1, distance_m, "rendered");
  }
  progress.finish();
  if (auto ok = recording->finish(); !ok) return report(ok.error());
  if (preview) {
    const auto png = sheet.sheet().png();
    if (!png) return report(png.error());
    if (auto ok = preview->write(*png); !ok) return report(ok.error());
  }
  fmt::print("{}: {} pairs of {}x{}, {:.2f} m, {}\n", arguments.out, frames, source.info().width, source.info().height,
             distance_m, source.info().description);
  return kDone;
}

}  // namespace

void add_simulate_command(CliCommand app, int& exit_code) {
  auto arguments = std::make_shared<SimulateArguments>();
  const CliCommand simulate = app.add_subcommand("simulate", "Render a course with exact truth as a recording");
  simulate.add_option("--out", arguments->out, "New folder for the recording").required().type_name("DIR");
  simulate.add_option("--preview", arguments->preview, "Also a contact sheet: images and their true disparity")
      .type_name("FILE.png");
  for (const drivers::SimulatorKey& key : drivers::simulator_keys()) {
    std::string flag = "--" + key.name;
    std::replace(flag.begin(), flag.end(), '_', '-');
    const CliOption option = simulate.add_option(flag, arguments->values[key.name], key.meaning);
    if (key.on_off) {
      // `--raw` alone switches on; `--shot-noise off` switches off.
      option.optional_value("on").type_name("[on|off]");
    } else {
      option.type_name("VALUE");
    }
  }
  simulate.footer(
      "Without options: the reference scene, 200 frames. Layout: KITTI odometry (image_0, image_1, calib.txt,\n"
      "times.txt), with --raw EuRoC (mav0/cam0, mav0/cam1). Truth either way: poses.txt (rectified left camera) and\n"
      "disp_0/ (16-bit PNG, px * 256, 0 = unknown).\n"
      "Examples:\n"
      "  cliquevo simulate --out walk --course walking --frames 400 --preview walk.png\n"
      "  cliquevo simulate --out raw --raw --movers 3 --noise-seed 2");
  simulate.callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace cliquevo::tools
