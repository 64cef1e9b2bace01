// SPDX-License-Identifier: BSD-3-Clause
// Dense stereo beside OpenCV's StereoBM, and rectification beside cv::remap: same pictures, same settings, one thread,
// the programs taking turns within one run; medians and minima of the thread's own time. Then two workers beside two
// copies of the one-thread program.
#include <algorithm>
#include <barrier>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <thread>
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

struct Times {
  double median_ms, least_ms;
};

Times times_of(const std::vector<double>& ms) { return {median(ms), *std::min_element(ms.begin(), ms.end())}; }

double thread_ms() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
}

double wall_ms() { return 1e-6 * static_cast<double>(monotonic_ns()); }

// Times of programs that take turns, `rounds` times each.
std::vector<Times> race(const std::vector<std::function<void()>>& programs, int rounds, double (*clock)() = thread_ms) {
  std::vector<std::vector<double>> times(programs.size());
  for (int round = 0; round <= rounds; ++round) {
    for (std::size_t i = 0; i < programs.size(); ++i) {
      const double begin_ms = clock();
      programs[i]();
      if (round > 0) times[i].push_back(clock() - begin_ms);  // round 0 warms up
    }
  }
  std::vector<Times> all;
  for (const auto& t : times) all.push_back(times_of(t));
  return all;
}

json beside(const std::string& what, const std::string& scene, int width, int height, const std::vector<Times>& t) {
  return {{"what", what},
          {"scene", scene},
          {"width", width},
          {"height", height},
          {"cliquevo_ms", t[0].median_ms},
          {"opencv_ms", t[1].median_ms},
          {"cliquevo_least_ms", t[0].least_ms},
          {"opencv_least_ms", t[1].least_ms},
          {"times_faster", t[1].median_ms / t[0].median_ms},
          {"times_faster_at_least", t[1].least_ms / t[0].least_ms}};
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

struct Rectified {
  Image<std::uint8_t> left, right, filtered;
  Image<std::int16_t> disparity;
};

Result<Rectified> rectify(const Scene& scene) {
  const auto rectifier = stereo::Rectifier::make(scene.calibration);
  if (!rectifier) return rectifier.error();
  const StereoModel& model = rectifier->model();
  Rectified pair;
  for (auto* image : {&pair.left, &pair.right, &pair.filtered}) image->resize(model.width, model.height);
  pair.disparity.resize(model.width, model.height);
  if (auto r = rectifier->rectify(stereo::CameraSide::left, scene.raw.left.cview(), pair.left.view()); !r)
    return r.error();
  if (auto r = rectifier->rectify(stereo::CameraSide::right, scene.raw.right.cview(), pair.right.view()); !r)
    return r.error();
  return pair;
}

// What is compared. StereoBM knows square windows, the x-Sobel filter and no smoothing.
enum class Work {
  shipped,  // our defaults beside the square window that comes nearest in area
  same,     // the same window, filter, checks and steps
  bare      // the same window and filter, no check
};

Result<json> bench_matching(const Scene& scene, Work work, int rounds) {
  auto pair = rectify(scene);
  if (!pair) return pair.error();
  const int width = pair->left.width();
  const int height = pair->left.height();
  stereo::StereoParams params;
  params.min_disparity = 0;
  params.num_disparities = scene.disparities;
  constexpr int kSquare = 9;  // px; StereoBM's time hardly depends on it
  if (work != Work::shipped) {
    params.prefilter = stereo::Prefilter::xsobel;
    params.window = params.window_height = kSquare;
    params.smoothing = 0;
  }
  if (work == Work::bare) {
    params.uniqueness_percent = 0;
    params.texture_threshold = 0;
    params.left_right_tolerance = -1;
    params.speckle_size = 0;
  }
  auto ours = stereo::DenseStereo::make(params, width, height);
  if (!ours) return ours.error();
  const auto theirs = cv::StereoBM::create(params.num_disparities, kSquare);
  theirs->setPreFilterType(cv::StereoBM::PREFILTER_XSOBEL);
  theirs->setPreFilterCap(params.prefilter_cap);
  theirs->setUniquenessRatio(params.uniqueness_percent);
  theirs->setTextureThreshold(params.texture_threshold);
  theirs->setDisp12MaxDiff(params.left_right_tolerance);
  theirs->setSpeckleWindowSize(params.speckle_size);
  theirs->setSpeckleRange(params.speckle_range * kDisparityScale);  // not documented: its unit is a sixteenth of a px
  const cv::Mat l = mat_of(pair->left);
  const cv::Mat r = mat_of(pair->right);
  cv::Mat their_disparity;
  const auto times = race({[&] {
                             (void)ours->compute(pair->left.cview(), pair->right.cview(), pair->filtered.view(),
                                                 pair->disparity.view());
                           },
                           [&] { theirs->compute(l, r, their_disparity); }},
                          rounds);
  const auto share = [&](auto&& known) {
    std::int64_t n = 0;
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) n += known(x, y) ? 1 : 0;
    }
    return static_cast<double>(n) / (static_cast<double>(width) * height);
  };
  const char* const what[] = {"whole stage as shipped", "whole stage, same settings", "bare matching"};
  json result = beside(what[static_cast<int>(work)], scene.name, width, height, times);
  result["disparities"] = params.num_disparities;
  result["cliquevo_window"] = {params.window, params.window_height};
  result["opencv_window"] = kSquare;
  result["cliquevo_density"] = share([&](int x, int y) { return pair->disparity.cview()(x, y) != kUnknownDisparity; });
  result["opencv_density"] = share([&](int x, int y) { return their_disparity.at<std::int16_t>(y, x) >= 0; });
  return result;
}

// Frames that two workers finish together, beside two threads with a matcher each: 1 would be perfect sharing.
Result<json> bench_workers(const Scene& scene, int rounds) {
  auto pair = rectify(scene);
  if (!pair) return pair.error();
  constexpr int kFrames = 4;  // of each thread
  stereo::StereoParams params;
  params.num_disparities = scene.disparities;
  const int width = pair->left.width();
  const int height = pair->left.height();
  auto first = stereo::DenseStereo::make(params, width, height);
  auto second = stereo::DenseStereo::make(params, width, height);
  params.workers = 2;
  auto shared = stereo::DenseStereo::make(params, width, height);
  if (!first || !second || !shared) return first.error();
  Rectified other;
  other.filtered.resize(width, height);
  other.disparity.resize(width, height);
  const auto match = [&](stereo::DenseStereo& stereo, Rectified& out, int frames) {
    for (int i = 0; i < frames; ++i) {
      (void)stereo.compute(pair->left.cview(), pair->right.cview(), out.filtered.view(), out.disparity.view());
    }
  };
  std::barrier meet(2);
  bool over = false;
  std::thread copy([&] {
    for (;;) {
      meet.arrive_and_wait();
      if (over) return;
      match(*second, other, kFrames);
      meet.arrive_and_wait();
    }
  });
  const auto times = race({[&] { match(*shared, *pair, 2 * kFrames); },
                           [&] {
                             meet.arrive_and_wait();
                             match(*first, *pair, kFrames);
                             meet.arrive_and_wait();
                           }},
                          rounds, wall_ms);
  over = true;
  meet.arrive_and_wait();
  copy.join();
  return json{{"what", "two workers beside two copies"},
              {"scene", scene.name},
              {"width", width},
              {"height", height},
              {"shared_ms", times[0].median_ms / (2 * kFrames)},
              {"copies_ms", times[1].median_ms / (2 * kFrames)},
              {"efficiency", times[1].median_ms / times[0].median_ms},
              {"efficiency_at_least", times[1].least_ms / times[0].least_ms}};
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
  const auto times =
      race({[&] { (void)rectifier->rectify(stereo::CameraSide::left, scene.raw.left.cview(), rectified.view()); },
            [&] { cv::remap(raw, out, map_a, map_b, cv::INTER_LINEAR); }},
           rounds);
  return beside("rectification of one image", scene.name, model.width, model.height, times);
}

// The simulator's first pair, and the KITTI drive's where it is there.
Result<std::vector<Scene>> open_scenes() {
  std::vector<Scene> scenes;
  drivers::SimulatorOptions options;
  options.frames = 2;
  auto simulator = drivers::open_simulator(options);
  if (!simulator) return simulator.error();
  auto sim = first_pair("sim", std::move(*simulator), 64);
  if (!sim) return sim.error();
  scenes.push_back(std::move(*sim));
  const std::filesystem::path drive = std::filesystem::path(test::data_dir()) / "kitti_raw";
  if (!std::filesystem::exists(drive)) return scenes;
  drivers::RecordingOptions recording;
  recording.path = drive.string();
  auto opened = drivers::open_recording(recording);
  if (!opened) return opened.error();
  auto kitti = first_pair("kitti_raw", std::move(*opened), 128);
  if (!kitti) return kitti.error();
  scenes.push_back(std::move(*kitti));
  return scenes;
}

void print_result(const json& result) {
  const auto number = [&result](const char* key) { return result.at(key).get<double>(); };
  fmt::print("{:30} {:10} {:4}x{:<4} ", result.at("what").get<std::string>(), result.at("scene").get<std::string>(),
             result.at("width").get<int>(), result.at("height").get<int>());
  if (result.contains("efficiency")) {
    fmt::print("shared {:7.2f} ms  copies {:7.2f} ms  {:5.2f} of theirs (minima {:.2f})\n", number("shared_ms"),
               number("copies_ms"), number("efficiency"), number("efficiency_at_least"));
  } else {
    fmt::print("cliquevo {:7.2f} ms  opencv {:7.2f} ms  {:5.2f} times faster (minima {:.2f})\n", number("cliquevo_ms"),
               number("opencv_ms"), number("times_faster"), number("times_faster_at_least"));
  }
  std::fflush(stdout);
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

  auto scenes = open_scenes();
  if (!scenes) return tools::report(scenes.error());
  json results = json::array();
  const auto keep = [&results](const Result<json>& result) {
    if (!result) {
      tools::report(result.error());
      return false;
    }
    results.push_back(*result);
    print_result(*result);
    return true;
  };
  for (const Scene& scene : *scenes) {
    for (const Work work : {Work::shipped, Work::same, Work::bare}) {
      if (!keep(bench_matching(scene, work, rounds))) return tools::kBadInput;
    }
    if (!keep(bench_workers(scene, rounds))) return tools::kBadInput;
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
