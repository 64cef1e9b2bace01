// SPDX-License-Identifier: BSD-3-Clause
// Dense stereo beside OpenCV's StereoBM, and rectification beside cv::remap: same pictures, same settings, one thread,
// the programs taking turns within one run; medians and ratios.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/isa.h"
#include "core/base/time.h"
#include "drivers/recording.h"
#include "drivers/simulator.h"
#include "stereo/dense_stereo.h"
#include "stereo/rectify.h"
#include "tests/support/test_data.h"
#include "tools/exit_code.h"

namespace {

using namespace cliquevo;
using nlohmann::json;

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2), values.end());
  return values[values.size() / 2];
}

// Median times in ms of programs that take turns, `rounds` times each.
std::vector<double> race(const std::vector<std::function<void()>>& programs, int rounds) {
  std::vector<std::vector<double>> times(programs.size());
  for (int round = 0; round <= rounds; ++round) {
    for (std::size_t i = 0; i < programs.size(); ++i) {
      const std::int64_t begin_ns = monotonic_ns();
      programs[i]();
      if (round > 0) times[i].push_back(1e-6 * static_cast<double>(monotonic_ns() - begin_ns));  // round 0 warms up
    }
  }
  std::vector<double> medians;
  for (const auto& t : times) medians.push_back(median(t));
  return medians;
}

cv::Mat mat_of(const Image<std::uint8_t>& image) {
  return {image.height(), image.width(), CV_8U, const_cast<std::uint8_t*>(image.cview().data),
          static_cast<std::size_t>(image.cview().stride)};
}

struct Scene {
  std::string name;
  drivers::StereoPair raw;
  StereoCalibration calibration;
  int disparities = 64;
};

Result<Scene> first_pair(const std::string& name, std::unique_ptr<drivers::FrameSource> source, int disparities) {
  Scene scene;
  scene.name = name;
  scene.calibration = source->info().calibration;
  scene.disparities = disparities;
  const auto more = source->next(scene.raw);
  if (!more) return more.error();
  if (!*more) return Error{"no frame in the source", name, "choose another"};
  return scene;
}

Result<json> bench_matching(const Scene& scene, bool checks, int rounds) {
  const auto rectifier = stereo::Rectifier::make(scene.calibration);
  if (!rectifier) return rectifier.error();
  const int width = rectifier->model().width;
  const int height = rectifier->model().height;
  Image<std::uint8_t> left(width, height), right(width, height), filtered(width, height);
  Image<std::int16_t> disparity(width, height);
  if (auto r = rectifier->rectify(stereo::Eye::left, scene.raw.left.cview(), left.view()); !r) return r.error();
  if (auto r = rectifier->rectify(stereo::Eye::right, scene.raw.right.cview(), right.view()); !r) return r.error();

  stereo::StereoParams params;
  params.min_disparity = 0;
  params.num_disparities = scene.disparities;
  if (!checks) {
    params.uniqueness_percent = 0;
    params.texture_threshold = 0;
    params.left_right_tolerance = -1;
    params.speckle_size = 0;
  }
  auto ours = stereo::DenseStereo::make(params, width, height);
  if (!ours) return ours.error();
  const auto theirs = cv::StereoBM::create(params.num_disparities, params.window);
  theirs->setPreFilterType(cv::StereoBM::PREFILTER_XSOBEL);
  theirs->setPreFilterCap(params.prefilter_cap);
  theirs->setUniquenessRatio(params.uniqueness_percent);
  theirs->setTextureThreshold(params.texture_threshold);
  theirs->setDisp12MaxDiff(params.left_right_tolerance);
  theirs->setSpeckleWindowSize(params.speckle_size);
  theirs->setSpeckleRange(params.speckle_range);
  const cv::Mat l = mat_of(left);
  const cv::Mat r = mat_of(right);
  cv::Mat their_disparity;
  const std::vector<double> ms =
      race({[&] { (void)ours->compute(left.cview(), right.cview(), filtered.view(), disparity.view()); },
            [&] { theirs->compute(l, r, their_disparity); }},
           rounds);
  const auto share = [&](auto&& known) {
    std::int64_t n = 0;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) n += known(x, y) ? 1 : 0;
    }
    return static_cast<double>(n) / (static_cast<double>(width) * height);
  };
  return json{{"what", checks ? "matching with every check" : "matching without checks"},
              {"scene", scene.name},
              {"width", width},
              {"height", height},
              {"disparities", params.num_disparities},
              {"window", params.window},
              {"cliquevo_ms", ms[0]},
              {"opencv_ms", ms[1]},
              {"times_faster", ms[1] / ms[0]},
              {"cliquevo_density", share([&](int x, int y) { return disparity.cview()(x, y) != kUnknownDisparity; })},
              {"opencv_density", share([&](int x, int y) { return their_disparity.at<std::int16_t>(y, x) >= 0; })}};
}

// One raw image through the same maps: ours, and OpenCV's fixed-point ones.
Result<json> bench_rectification(const Scene& scene, int rounds) {
  const auto rectifier = stereo::Rectifier::make(scene.calibration);
  if (!rectifier) return rectifier.error();
  const StereoModel& model = rectifier->model();
  const CameraCalibration& c = scene.calibration.left;
  const Eigen::Matrix3d R = scene.calibration.prescribed ? scene.calibration.prescribed->R_left
                                                         : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  const cv::Matx33d K(c.fx_px, 0, c.cx_px, 0, c.fy_px, c.cy_px, 0, 0, 1);
  const cv::Matx33d P(model.fx_px, 0, model.cx_px, 0, model.fy_px, model.cy_px, 0, 0, 1);
  cv::Matx33d turn;
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) turn(i, k) = R(i, k);
  }
  cv::Mat map_a, map_b, out;
  cv::initUndistortRectifyMap(K, std::vector<double>(c.coefficients.begin(), c.coefficients.end()), turn, P,
                              {model.width, model.height}, CV_16SC2, map_a, map_b);
  Image<std::uint8_t> rectified(model.width, model.height);
  const cv::Mat raw = mat_of(scene.raw.left);
  const std::vector<double> ms =
      race({[&] { (void)rectifier->rectify(stereo::Eye::left, scene.raw.left.cview(), rectified.view()); },
            [&] { cv::remap(raw, out, map_a, map_b, cv::INTER_LINEAR); }},
           rounds);
  return json{{"what", "rectification of one image"},
              {"scene", scene.name},
              {"width", model.width},
              {"height", model.height},
              {"cliquevo_ms", ms[0]},
              {"opencv_ms", ms[1]},
              {"times_faster", ms[1] / ms[0]}};
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Dense stereo and rectification beside OpenCV's, taking turns on one thread"};
  int rounds = 60;
  std::string file;
  app.add_option("--rounds", rounds, "Runs of each program")->check(CLI::Range(3, 10000))->capture_default_str();
  app.add_option("--json", file, "Write the results here as well");
  CLI11_PARSE(app, argc, argv);
  cv::setNumThreads(1);

  std::vector<Scene> scenes;
  json results = json::array();
  const auto take = [&scenes](Result<Scene> scene) {
    if (!scene) return false;
    scenes.push_back(std::move(*scene));
    return true;
  };
  drivers::SimulatorOptions options;
  options.frames = 2;
  auto simulator = drivers::open_simulator(options);
  if (!simulator) return tools::report(simulator.error());
  if (!take(first_pair("sim", std::move(*simulator), 64))) return tools::kBadInput;
  const std::filesystem::path drive = std::filesystem::path(test::data_dir()) / "kitti_raw";
  if (std::filesystem::exists(drive)) {
    drivers::RecordingOptions recording;
    recording.path = drive.string();
    auto opened = drivers::open_recording(recording);
    if (!opened) return tools::report(opened.error());
    if (!take(first_pair("kitti_raw", std::move(*opened), 128))) return tools::kBadInput;
  }
  const auto keep = [&results](const Result<json>& result) {
    if (!result) {
      tools::report(result.error());
      return false;
    }
    results.push_back(*result);
    fmt::print("{:28} {:10} {:4}x{:<4} cliquevo {:7.2f} ms  opencv {:7.2f} ms  {:5.2f} times faster\n",
               result->at("what").get<std::string>(), result->at("scene").get<std::string>(),
               result->at("width").get<int>(), result->at("height").get<int>(), result->at("cliquevo_ms").get<double>(),
               result->at("opencv_ms").get<double>(), result->at("times_faster").get<double>());
    return true;
  };
  for (const Scene& scene : scenes) {
    for (const bool checks : {true, false}) {
      if (!keep(bench_matching(scene, checks, rounds))) return tools::kBadInput;
    }
    if (!scene.calibration.rectified && !keep(bench_rectification(scene, rounds))) return tools::kBadInput;
  }
  if (!file.empty()) {
    std::ofstream out(file);
    out << json{{"instruction_set", isa_name(active_isa())}, {"opencv", cv::getVersionString()}, {"results", results}}
               .dump(2)
        << "\n";
    if (!out) return tools::report({"cannot write the results", file, "check the folder and its rights"});
  }
  return tools::kDone;
}
