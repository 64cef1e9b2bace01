// SPDX-License-Identifier: BSD-3-Clause
// Features to pose, beside a pipeline put together from OpenCV: same rectified images, same disparity, one thread, the
// programs taking turns frame by frame within one run. Stereo is not in these times. Accuracy against truth as well.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "core/base/isa.h"
#include "core/vo/visual_odometry.h"
#include "daemon/pipeline/trajectory_file.h"
#include "drivers/recording.h"
#include "drivers/simulator.h"
#include "stereo/dense_stereo.h"
#include "stereo/rectify.h"
#include "tests/bench/opencv_odometry.h"
#include "tests/support/test_data.h"
#include "tools/evaluation.h"
#include "tools/exit_code.h"

namespace {

using namespace cliquevo;
using nlohmann::json;

struct Frame {
  TimestampNs stamp_ns = 0;
  Image<std::uint8_t> left;
  Image<std::uint8_t> right;
  Image<std::uint8_t> filtered;
  Image<std::int16_t> disparity;
};

struct Sequence {
  std::string description;
  StereoModel model;
  std::vector<Frame> frames;
  std::vector<RigidTransform> truth;  // empty = unknown
};

Result<std::unique_ptr<drivers::FrameSource>> open_source(const std::string& source) {
  if (source.rfind("sim:", 0) == 0) {
    const auto options = drivers::parse_simulator_options(source.substr(4));
    if (!options) return options.error();
    auto simulator = drivers::open_simulator(*options);
    if (!simulator) return simulator.error();
    return std::unique_ptr<drivers::FrameSource>(std::move(*simulator));
  }
  drivers::RecordingOptions options;
  options.path = source;
  return drivers::open_recording(options);
}

// Everything that is not timed: images read, rectified and matched.
Result<Sequence> prepare(const std::string& name, std::size_t most) {
  auto source = open_source(name);
  if (!source) return source.error();
  const drivers::SourceInfo& info = (*source)->info();
  const auto rectifier = stereo::Rectifier::make(info.calibration);
  if (!rectifier) return rectifier.error();
  Sequence sequence;
  sequence.description = info.description;
  sequence.model = rectifier->model();
  const int width = sequence.model.width;
  const int height = sequence.model.height;
  auto dense = stereo::DenseStereo::make(stereo::StereoParams{}, width, height);
  if (!dense) return dense.error();

  drivers::StereoPair pair;
  while (sequence.frames.size() < most) {
    const auto more = (*source)->next(pair);
    if (!more) return more.error();
    if (!*more) break;
    Frame frame{
        pair.stamp_ns, {width, height}, {width, height}, {width, height}, {width, height},
    };
    if (auto r = rectifier->rectify(stereo::CameraSide::left, pair.left.view(), frame.left.view()); !r)
      return r.error();
    if (auto r = rectifier->rectify(stereo::CameraSide::right, pair.right.view(), frame.right.view()); !r)
      return r.error();
    if (auto r = dense->compute(frame.left.cview(), frame.right.cview(), frame.filtered.view(), frame.disparity.view());
        !r) {
      return r.error();
    }
    if (pair.truth_T_world_camera) sequence.truth.push_back(*pair.truth_T_world_camera);
    sequence.frames.push_back(std::move(frame));
  }
  const auto poses = std::filesystem::path(name) / "poses.txt";
  if (sequence.truth.empty() && std::filesystem::exists(poses)) {
    const auto reference = daemon::read_trajectory(poses.string());
    if (!reference) return reference.error();
    for (const daemon::StampedPose& pose : reference->poses) sequence.truth.push_back(pose.T_world_camera);
  }
  if (sequence.frames.size() < 2) return Error{"too few frames", name, "two are needed"};
  sequence.truth.resize(std::min(sequence.truth.size(), sequence.frames.size()));
  return sequence;
}

// What is measured of one program on one sequence.
struct Contender {
  std::string name;
  bench::OpenCvParams opencv;    // of those that are OpenCV's
  std::vector<double> frame_ms;  // every frame of every pass but the first frame
  std::vector<RigidTransform> poses;
  int failed = 0;
};

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Reads a frame's images, so that each program finds them as stereo has just left them: in the processor's caches.
void touch(const Frame& frame) {
  unsigned sum = 0;
  const auto read = [&sum](const auto& image) {
    for (int y = 0; y < image.height; ++y) {
      for (int x = 0; x < image.width; x += 16) sum += static_cast<unsigned>(image(x, y));
    }
  };
  read(frame.left.cview());
  read(frame.right.cview());
  read(frame.filtered.cview());
  read(frame.disparity.cview());
  asm volatile("" : : "r"(sum));
}

template <typename Step>
void timed(Contender& contender, bool count, Step&& step) {
  const std::int64_t start = monotonic_ns();
  const bool good = step();
  const double ms = static_cast<double>(monotonic_ns() - start) * 1e-6;
  if (!count) return;
  contender.frame_ms.push_back(ms);
  if (!good) ++contender.failed;
}

// One pass over the sequence, the programs taking turns; who begins changes with every frame. The first contender is
// ours, the others are OpenCV's.
Result<void> run_pass(const Sequence& sequence, std::vector<Contender>& contenders) {
  auto ours = vo::VisualOdometry::make(sequence.model, vo::VoParams{});
  if (!ours) return ours.error();
  std::vector<bench::OpenCvOdometry> theirs;
  for (std::size_t k = 1; k < contenders.size(); ++k) theirs.emplace_back(sequence.model, contenders[k].opencv);

  for (Contender& contender : contenders) contender.poses.clear();
  Result<void> outcome;
  for (std::size_t i = 0; i < sequence.frames.size(); ++i) {
    const Frame& frame = sequence.frames[i];
    const bool count = i > 0;
    for (std::size_t turn = 0; turn < contenders.size(); ++turn) {
      const std::size_t k = (i + turn) % contenders.size();
      touch(frame);
      timed(contenders[k], count, [&] {
        if (k > 0) return theirs[k - 1].process(frame.left.cview(), frame.disparity.cview());
        outcome = ours->process(
            {frame.stamp_ns, frame.left.cview(), frame.right.cview(), frame.filtered.cview(), frame.disparity.cview()});
        return outcome.ok() && ours->estimate().status == vo::Status::valid;
      });
      if (!outcome) return outcome;
      contenders[k].poses.push_back(k > 0 ? theirs[k - 1].T_world_camera() : ours->estimate().T_world_camera);
    }
  }
  return {};
}

json judge(const Sequence& sequence, const Contender& contender, const std::vector<double>& lengths) {
  json out = {{"name", contender.name},
              {"median_ms", median(contender.frame_ms)},
              {"failed_frames", contender.failed},
              {"frames_timed", contender.frame_ms.size()}};
  std::vector<tools::PosePair> pairs;
  for (std::size_t i = 0; i < sequence.truth.size(); ++i) {
    pairs.push_back({sequence.frames[i].stamp_ns, i, sequence.truth[i], contender.poses[i]});
  }
  if (pairs.size() < 2) return out;
  tools::EvaluationOptions options;
  options.lengths_m = lengths;
  const tools::Evaluation result = tools::evaluate(pairs, options);
  out["segment_error_pct"] = result.t_err_pct ? json(*result.t_err_pct) : json(nullptr);
  out["segment_error_deg_m"] = result.r_err_deg_m ? json(*result.r_err_deg_m) : json(nullptr);
  out["ate_m"] = result.ate_m;
  out["end_error_m"] = result.end_m;
  return out;
}

Result<json> bench_source(const std::string& name, std::size_t most, int passes, const std::vector<int>& features,
                          const std::vector<double>& lengths) {
  const auto sequence = prepare(name, most);
  if (!sequence) return sequence.error();
  std::vector<Contender> contenders(1);
  contenders[0].name = "cliquevo";
  for (const int n : features) {
    Contender contender;
    contender.name = fmt::format("opencv {} good features + LK + PnP", n);
    contender.opencv.max_features = n;
    contenders.push_back(contender);
  }
  Contender fast;
  fast.name = fmt::format("opencv {} FAST + LK + PnP", features.front());
  fast.opencv.corners = bench::Corners::fast;
  fast.opencv.max_features = features.front();
  contenders.push_back(fast);
  for (int pass = 0; pass < passes; ++pass) {
    for (Contender& contender : contenders) contender.failed = 0;
    if (auto run = run_pass(*sequence, contenders); !run) return run.error();
  }
  json out = {{"source", name},
              {"description", sequence->description},
              {"width", sequence->model.width},
              {"height", sequence->model.height},
              {"frames", sequence->frames.size()},
              {"programs", json::array()}};
  fmt::print("{} ({}x{}, {} frames, {} passes)\n", name, sequence->model.width, sequence->model.height,
             sequence->frames.size(), passes);
  const double own_ms = median(contenders[0].frame_ms);
  for (const Contender& contender : contenders) {
    json entry = judge(*sequence, contender, lengths);
    entry["time_ratio"] = own_ms > 0.0 ? entry["median_ms"].get<double>() / own_ms : 0.0;
    const bool judged = entry.contains("segment_error_pct") && entry["segment_error_pct"].is_number();
    fmt::print("  {:39} {:7.2f} ms  {:5.2f} x   {} failed   {}\n", contender.name, entry["median_ms"].get<double>(),
               entry["time_ratio"].get<double>(), contender.failed,
               judged ? fmt::format("{:.3f} %  {:.5f} deg/m", entry["segment_error_pct"].get<double>(),
                                    entry["segment_error_deg_m"].get<double>())
                      : "no segments to judge");
    out["programs"].push_back(std::move(entry));
  }
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  std::vector<std::string> sources;
  std::vector<double> lengths = {5, 10, 20, 40, 60, 80, 100};
  std::size_t most = 200;
  int passes = 3;
  std::vector<int> features = {500, 1000};
  std::string json_path;
  CLI::App app("Times odometry (features to pose) beside an OpenCV pipeline and judges both against truth.");
  app.add_option("source", sources, "Recordings or sim:KEY=VALUE,...; default: what the simulator and the data offer");
  app.add_option("--frames", most, "Frames of each source, at most")->capture_default_str();
  app.add_option("--passes", passes, "Times each is run")->check(CLI::Range(1, 1000))->capture_default_str();
  app.add_option("--features", features, "Features a frame for OpenCV's programs; ours runs with its defaults")
      ->delimiter(',')
      ->check(CLI::Range(6, 100000))
      ->capture_default_str();
  app.add_option("--lengths", lengths, "Segment lengths, m")->delimiter(',')->capture_default_str();
  app.add_option("--json", json_path, "Write the figures there as well");
  CLI11_PARSE(app, argc, argv);

  cv::setNumThreads(1);
  if (sources.empty()) {
    sources.push_back(fmt::format("sim:frames={}", most));
    for (const char* name : {"kitti_odometry_06", "kitti_raw"}) {
      if (test::have_data(name)) sources.push_back(test::data_dir() + "/" + name);
    }
  }
  json report = {{"isa", isa_name(active_isa())}, {"opencv", CV_VERSION}, {"sources", json::array()}};
  for (const std::string& source : sources) {
    auto result = bench_source(source, most, passes, features, lengths);
    if (!result) return tools::report(result.error());
    report["sources"].push_back(std::move(*result));
  }
  if (!json_path.empty()) {
    std::ofstream file(json_path);
    file << report.dump(2) << '\n';
    if (!file.flush()) return tools::report({"cannot write", json_path, "check the folder and the free space"});
  }
  return 0;
}
