// SPDX-License-Identifier: BSD-3-Clause
// cliquevo convert: recordings from one form into another.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "drivers/recorder.h"
#include "stereo/rectify.h"
#include "tools/exit_code.h"
#include "tools/logged_poses.h"
#include "tools/progress.h"
#include "tools/record.h"
#include "tools/recording_folder.h"
#include "tools/ros2_bag.h"
#include "tools/skipped_pairs.h"
#include "tools/source_argument.h"
#include "tools/stop_on_signal.h"

namespace cliquevo::tools {

namespace {

namespace fs = std::filesystem;

struct ConvertArguments {
  SourceArgument source;
  std::string out;
  std::string config;  // where the camera sits
  std::string to;      // empty = by `out` and the source
  bool png = false;    // images of an MCAP as PNG
};

// Where the pairs go.
class Target {
 public:
  virtual ~Target() = default;
  virtual Result<void> add(const drivers::StereoPair& pair) = 0;
  virtual Result<void> finish() = 0;
};

class LogTarget final : public Target {
 public:
  LogTarget(drivers::Recorder recorder, const drivers::SourceInfo& info)
      : recorder_(std::move(recorder)), info_(info) {}
  Result<void> add(const drivers::StereoPair& pair) override {
    recorder_.add(pair, drivers::log_utime(info_, pair));
    if (const auto failure = recorder_.failure()) return *failure;
    return {};
  }
  Result<void> finish() override { return recorder_.stop(); }

 private:
  drivers::Recorder recorder_;
  const drivers::SourceInfo& info_;
};

// Pairs, and what the log has of the way between them.
class BagTarget final : public Target {
 public:
  BagTarget(Ros2Bag bag, LoggedPoses logged) : bag_(std::move(bag)), logged_(std::move(logged)) {}
  Result<void> add(const drivers::StereoPair& pair) override {
    if (auto ok = bag_.add(pair); !ok) return ok;
    return add_poses(pair.stamp_ns / 1000);
  }
  Result<void> finish() override {
    if (auto ok = add_poses(INT64_MAX); !ok) return ok;
    return bag_.finish();
  }

 private:
  Result<void> add_poses(std::int64_t up_to) {
    for (; odometry_ < logged_.odometry.size() && logged_.odometry[odometry_].utime <= up_to; ++odometry_) {
      if (auto ok = bag_.add(logged_.odometry[odometry_]); !ok) return ok;
    }
    for (; poses_ < logged_.poses.size() && logged_.poses[poses_].utime <= up_to; ++poses_) {
      if (auto ok = bag_.add(logged_.poses[poses_]); !ok) return ok;
    }
    for (; points_ < logged_.points.size() && logged_.points.utime(points_) <= up_to; ++points_) {
      const auto points = logged_.points.read(points_);
      if (!points) continue;
      if (auto ok = bag_.add(*points); !ok) return ok;
    }
    return {};
  }

  Ros2Bag bag_;
  LoggedPoses logged_;
  std::size_t odometry_ = 0;
  std::size_t poses_ = 0;
  std::size_t points_ = 0;
};

class FolderTarget final : public Target {
 public:
  FolderTarget(RecordingFolder folder, std::optional<stereo::Rectifier> rectifier)
      : folder_(std::move(folder)), rectifier_(std::move(rectifier)) {}
  Result<void> add(const drivers::StereoPair& pair) override {
    if (!rectifier_) return folder_.add(pair.left.cview(), pair.right.cview(), pair.stamp_ns);
    const StereoModel& model = rectifier_->model();
    left_.resize(model.width, model.height);
    right_.resize(model.width, model.height);
    if (auto ok = rectifier_->rectify(stereo::CameraSide::left, pair.left.cview(), left_.view()); !ok) return ok;
    if (auto ok = rectifier_->rectify(stereo::CameraSide::right, pair.right.cview(), right_.view()); !ok) return ok;
    return folder_.add(left_.cview(), right_.cview(), pair.stamp_ns);
  }
  Result<void> finish() override { return folder_.finish(); }

 private:
  RecordingFolder folder_;
  std::optional<stereo::Rectifier> rectifier_;  // none: as they are
  Image<std::uint8_t> left_;
  Image<std::uint8_t> right_;
};

std::string target_form(const ConvertArguments& arguments, const drivers::SourceInfo& info) {
  if (!arguments.to.empty()) return arguments.to;
  if (fs::path(arguments.out).extension() == ".lcm") return "log";
  if (fs::path(arguments.out).extension() == ".mcap") return "mcap";
  return info.calibration.rectified ? "kitti" : "euroc";
}

Result<std::unique_ptr<Target>> make_bag(const ConvertArguments& arguments, const drivers::SourceInfo& info) {
  daemon::Config config = daemon::default_config();
  if (!arguments.config.empty()) {
    auto read = daemon::read_config(arguments.config);
    if (!read) return read.error();
    config = std::move(*read);
  }
  auto bag =
      Ros2Bag::create(arguments.out, info, config.T_body_camera, arguments.png ? BagImages::png : BagImages::plain);
  if (!bag) return bag.error();
  return std::unique_ptr<Target>(
      std::make_unique<BagTarget>(std::move(*bag), read_logged_poses(arguments.source.text)));
}

Result<std::unique_ptr<Target>> make_folder(const ConvertArguments& arguments, const drivers::SourceInfo& info,
                                            const std::string& form) {
  StereoCalibration calibration = info.calibration;
  std::optional<stereo::Rectifier> rectifier;
  if (form == "kitti" && !calibration.rectified) {
    auto made = stereo::Rectifier::make(calibration);
    if (!made) return made.error();
    rectifier.emplace(std::move(*made));
    calibration = {};
    calibration.rectified = true;
    calibration.prescribed = PrescribedRectification{};
    calibration.prescribed->model = rectifier->model();
  }
  auto folder = RecordingFolder::create(arguments.out, form == "kitti" ? FolderLayout::kitti : FolderLayout::euroc,
                                        calibration, info.rate_hz);
  if (!folder) return folder.error();
  if (form == "euroc" && info.calibration.prescribed && !info.calibration.rectified) {
    // EuRoC's files cannot say it; replay with --calibration OUT follows it.
    for (const bool left : {true, false}) {
      const std::string path = arguments.out + (left ? "/left.yaml" : "/right.yaml");
      if (auto ok = write_text(path, ros_camera_info(info.calibration, left)); !ok) return ok.error();
    }
  }
  return std::unique_ptr<Target>(std::make_unique<FolderTarget>(std::move(*folder), std::move(rectifier)));
}

Result<std::unique_ptr<Target>> make_target(const ConvertArguments& arguments, const drivers::SourceInfo& info) {
  const std::string form = target_form(arguments, info);
  if (form == "log") {
    drivers::RecorderOptions options;
    options.path = arguments.out;
    options.wait_when_full = true;
    auto recorder = drivers::Recorder::start(options, info);
    if (!recorder) return recorder.error();
    return std::unique_ptr<Target>(std::make_unique<LogTarget>(std::move(*recorder), info));
  }
  if (form == "mcap") return make_bag(arguments, info);
  return make_folder(arguments, info, form);
}

int run(const ConvertArguments& arguments) {
  if (auto usable = check_source(arguments.source); !usable) return report(usable.error(), kWrongUsage);
  auto source = open_source(arguments.source, daemon::default_config().source);
  if (!source) return report(source.error());
  const drivers::SourceInfo& info = (*source)->info();
  if (arguments.png && target_form(arguments, info) != "mcap") {
    return report({"wrong usage", "--png", "of an MCAP alone: let OUT end in .mcap, or add --to mcap"}, kWrongUsage);
  }
  auto target = make_target(arguments, info);
  if (!target) return report(target.error());

  const StopOnSignal signals;
  Progress progress(info.frame_count);
  drivers::StereoPair pair;
  std::optional<Error> error;
  std::int64_t count = 0;
  SkippedPairs skipped;
  const std::int64_t most_skipped = std::max<std::int64_t>(1000, info.frame_count);
  while (!error) {
    if (StopOnSignal::received()) {
      error = Error{"interrupted", fmt::format("after {} pairs", count), "convert again for all of them"};
      break;
    }
    const auto more = (*source)->next(pair);
    if (!more) {
      skipped.add(pair.index, more.error());
      if (skipped.count() > most_skipped) error = more.error();
      continue;
    }
    if (!*more) break;
    if (auto ok = (*target)->add(pair); !ok) error = ok.error();
    progress.update(++count, 0.0, "converted");
  }
  progress.finish();
  if (auto ok = (*target)->finish(); !ok && !error) error = ok.error();
  if (error) return report(*error);
  if (count == 0 && !skipped.empty()) return report(skipped.entries().front().error);
  fmt::print("{}: {} pairs of {}x{} from {}\n", arguments.out, count, info.width, info.height, info.description);
  if (!skipped.empty()) fmt::print("{} pairs skipped: later ones move up in files without stamps\n", skipped.count());
  if (const std::string finding = (*source)->finding(); !finding.empty()) {
    warn({finding.substr(0, finding.find(':')), arguments.source.text,
          "see `cliquevo replay`; --swap-eyes exchanges them"});
  }
  if (fs::exists(arguments.out + "/left.yaml")) {
    fmt::print("its prescribed rectification: replay it with --calibration {}/left.yaml\n", arguments.out);
  }
  return kDone;
}

}  // namespace

void add_convert_command(CliCommand app, int& exit_code) {
  auto arguments = std::make_shared<ConvertArguments>();
  const CliCommand convert =
      app.add_subcommand("convert", "Turn a recording into an LCM log, an MCAP, a KITTI or an EuRoC folder");
  convert.add_option("SOURCE", arguments->source.text, "A recording (folder or log), sim, or sim:key=value,...")
      .required();
  convert.add_option("OUT", arguments->out, "New log (FILE.lcm), bag (FILE.mcap) or folder").required();
  convert
      .add_option("--to", arguments->to,
                  "log, mcap, kitti (rectified pairs), or euroc (as grabbed); default: by OUT's name, else by what the "
                  "source holds")
      .one_of({"log", "mcap", "kitti", "euroc"})
      .type_name("FORM");
  convert.add_option("--config", arguments->config, "Of an MCAP: where the camera sits on the body (section body)")
      .type_name("FILE");
  convert.add_flag("--png", arguments->png, "Of an MCAP: images as PNG (CompressedImage), lossless and smaller");
  add_calibration_options(convert, arguments->source);
  add_recording_options(convert, arguments->source);
  convert.footer(
      "Pixels and stamps are kept as they are, but for kitti, which is rectified on the way where it must be.\n"
      "Examples:\n"
      "  cliquevo convert drive.lcm drive.mcap\n"
      "  cliquevo convert drive.lcm drive_euroc\n"
      "  cliquevo convert drive.lcm drive_kitti --to kitti\n"
      "  cliquevo convert /data/indoor indoor.lcm");
  convert.callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace cliquevo::tools
