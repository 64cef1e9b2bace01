// SPDX-License-Identifier: BSD-3-Clause
// How right the disparities are: every switch of the dense stereo stage alone, and OpenCV's matchers, on pairs whose
// disparity is known. Writes the tables of stereo/README.md.
#include <algorithm>
#include <array>
#include <cmath>
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
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "drivers/simulator.h"
#include "stereo/dense_stereo.h"
#include "tests/support/test_data.h"
#include "tools/exit_code.h"

namespace {

using namespace cliquevo;
using nlohmann::json;

struct Pair {
  cv::Mat left, right;
  cv::Mat truth;  // float, px; not above 0 where unknown
};

struct Group {
  std::string name;
  int disparities;
  std::vector<Pair> pairs;
};

cv::Mat truth_of(const std::string& file) {
  cv::Mat truth;
  cv::imread(file, cv::IMREAD_UNCHANGED).convertTo(truth, CV_32F, 1.0 / 256.0);
  return truth;
}

cv::Mat copy_of(ImageView<const std::uint8_t> image) {
  return cv::Mat(image.height, image.width, CV_8U, const_cast<std::uint8_t*>(image.data),
                 static_cast<std::size_t>(image.stride))
      .clone();
}

std::vector<Group> recorded_groups() {
  std::vector<Group> groups;
  const std::filesystem::path data = test::data_dir();
  const auto grey = [](const std::filesystem::path& file) { return cv::imread(file.string(), cv::IMREAD_GRAYSCALE); };
  const auto kitti = data / "kitti_stereo_2012";
  if (std::filesystem::exists(kitti)) {
    groups.push_back({"KITTI 2012", 128, {}});
    std::vector<cv::String> files;
    cv::glob((kitti / "disp_noc" / "*_10.png").string(), files);
    for (const cv::String& file : files) {
      const std::string name = std::filesystem::path(file).filename().string();
      groups.back().pairs.push_back({grey(kitti / "image_0" / name), grey(kitti / "image_1" / name), truth_of(file)});
    }
  }
  const auto motorcycle = data / "middlebury_motorcycle";
  if (std::filesystem::exists(motorcycle)) {
    groups.push_back({"motorcycle", 64, {}});
    std::string left, right;
    for (const auto& entry : std::filesystem::directory_iterator(motorcycle)) {
      const std::string name = entry.path().filename().string();
      if (name.find("left") != std::string::npos || name.find("im0") != std::string::npos) left = entry.path().string();
      if (name.find("right") != std::string::npos || name.find("im1") != std::string::npos) {
        right = entry.path().string();
      }
    }
    groups.back().pairs.push_back({grey(left), grey(right), truth_of((motorcycle / "disparity.png").string())});
  }
  return groups;
}

Result<Group> simulated_group(int frames) {
  constexpr int kApart = 10;  // frames of the course
  Group group{"simulator", 64, {}};
  for (const std::uint64_t seed : {1, 2, 3}) {
    drivers::SimulatorOptions options;
    options.frames = frames * kApart;
    options.every = kApart;
    options.world_seed = seed;
    options.noise_seed = seed;
    auto simulator = drivers::open_simulator(options);
    if (!simulator) return simulator.error();
    drivers::StereoPair pair;
    for (auto more = (*simulator)->next(pair);; more = (*simulator)->next(pair)) {
      if (!more) return more.error();
      if (!*more) break;
      const auto truth = (*simulator)->truth_disparity();
      cv::Mat known(truth.height, truth.width, CV_32F);
      for (int y = 0; y < truth.height; ++y) {
        for (int x = 0; x < truth.width; ++x) known.at<float>(y, x) = std::isfinite(truth(x, y)) ? truth(x, y) : 0.0F;
      }
      group.pairs.push_back({copy_of(pair.left.cview()), copy_of(pair.right.cview()), known});
    }
  }
  return group;
}

// int16, px * 16, below 0 where unknown.
using Matcher = std::function<cv::Mat(const Pair&, int disparities)>;

struct Score {
  static constexpr int kBins = 16;
  std::int64_t known = 0, answered = 0, wrong = 0, right = 0;
  double squares = 0.0;
  std::array<std::int64_t, kBins> ours{}, true_ones{};

  void add(const Pair& pair, const cv::Mat& disparity) {
    for (int y = 0; y < disparity.rows; ++y) {
      for (int x = 0; x < disparity.cols; ++x) {
        const double truth = pair.truth.at<float>(y, x);
        if (!(truth > 0.0)) continue;
        ++known;
        const int d = disparity.at<std::int16_t>(y, x);
        if (d < 0) continue;
        ++answered;
        const double error = d / 16.0 - truth;
        wrong += std::abs(error) > 3.0 ? 1 : 0;
        if (std::abs(error) > 1.0) continue;
        ++right;
        squares += error * error;
        const auto bin = [](double v) { return static_cast<std::size_t>(std::floor((v - std::floor(v)) * kBins)); };
        ++ours[bin(d / 16.0)];
        ++true_ones[bin(truth + 0.5 / kBins)];  // ours are rounded to the nearest sixteenth
      }
    }
  }
  json result() const {
    double worst_bin = 0.0;
    for (int i = 0; i < kBins; ++i) {
      worst_bin = std::max(worst_bin,
                           static_cast<double>(ours[i]) / static_cast<double>(std::max<std::int64_t>(1, true_ones[i])));
    }
    const auto share = [](std::int64_t a, std::int64_t b) {
      return static_cast<double>(a) / static_cast<double>(std::max<std::int64_t>(1, b));
    };
    return {{"density", share(answered, known)},
            {"wrong", share(wrong, answered)},
            {"rms_px", std::sqrt(squares / static_cast<double>(std::max<std::int64_t>(1, right)))},
            {"fullest_bin", worst_bin}};
  }
};

Matcher ours(const stereo::StereoParams& given) {
  return [given](const Pair& pair, int disparities) {
    stereo::StereoParams params = given;
    params.num_disparities = disparities;
    const int width = pair.left.cols;
    const int height = pair.left.rows;
    cv::Mat out(height, width, CV_16S, cv::Scalar(kUnknownDisparity));
    cv::Mat filtered(height, width, CV_8U);
    auto dense = stereo::DenseStereo::make(params, width, height);
    const auto view = [](const cv::Mat& m) {
      return ImageView<const std::uint8_t>{m.data, m.cols, m.rows, static_cast<std::ptrdiff_t>(m.step)};
    };
    if (!dense || !dense->compute(view(pair.left), view(pair.right), {filtered.data, width, height, width},
                                  {out.ptr<std::int16_t>(), width, height, width})) {
      throw CLI::RuntimeError("the matcher refused", tools::kBadInput);
    }
    return out;
  };
}

Matcher block_matcher(int window) {
  return [window](const Pair& pair, int disparities) {
    const auto matcher = cv::StereoBM::create(disparities, window);
    const stereo::StereoParams same;
    matcher->setPreFilterType(cv::StereoBM::PREFILTER_XSOBEL);
    matcher->setPreFilterCap(same.prefilter_cap);
    matcher->setUniquenessRatio(same.uniqueness_percent);
    matcher->setTextureThreshold(same.texture_threshold);
    matcher->setDisp12MaxDiff(same.left_right_tolerance);
    matcher->setSpeckleWindowSize(same.speckle_size);
    matcher->setSpeckleRange(same.speckle_range * kDisparityScale);  // not documented: StereoBM's own unit
    cv::Mat out;
    matcher->compute(pair.left, pair.right, out);
    return out;
  };
}

Matcher semi_global_matcher() {
  return [](const Pair& pair, int disparities) {
    constexpr int kBlock = 5;
    const stereo::StereoParams same;
    const auto matcher = cv::StereoSGBM::create(0, disparities, kBlock, 8 * kBlock * kBlock, 32 * kBlock * kBlock,
                                                same.left_right_tolerance, same.prefilter_cap, same.uniqueness_percent,
                                                same.speckle_size, same.speckle_range);
    cv::Mat out;
    matcher->compute(pair.left, pair.right, out);
    return out;
  };
}

struct Candidate {
  std::string name;
  Matcher match;
};

std::vector<Candidate> candidates() {
  stereo::StereoParams shipped;
  shipped.min_disparity = 0;  // as OpenCV's search
  std::vector<Candidate> list{{"**as shipped**", ours(shipped)}};
  const auto with = [&](const std::string& name, const std::function<void(stereo::StereoParams&)>& change) {
    stereo::StereoParams params = shipped;
    change(params);
    list.push_back({name, ours(params)});
  };
  with("pre-filter: x-Sobel", [](auto& p) { p.prefilter = stereo::Prefilter::xsobel; });
  with("pre-filter: none", [](auto& p) { p.prefilter = stereo::Prefilter::none; });
  for (const auto& [w, h] : {std::pair{7, 7}, {9, 9}, {11, 11}, {13, 13}, {9, 7}, {11, 7}, {15, 7}, {13, 5}, {13, 9}}) {
    with(fmt::format("window {}x{}", w, h), [w = w, h = h](auto& p) {
      p.window = w;
      p.window_height = h;
    });
  }
  for (const int n : {0, 1, 3}) with(fmt::format("smoothing {}", n), [n](auto& p) { p.smoothing = n; });
  for (const int n : {0, 5, 15}) with(fmt::format("uniqueness {} %", n), [n](auto& p) { p.uniqueness_percent = n; });
  for (const int n : {0, 4}) with(fmt::format("texture {}", n), [n](auto& p) { p.texture_threshold = n; });
  for (const int n : {-1, 0, 2}) with(fmt::format("left-right {} px", n), [n](auto& p) { p.left_right_tolerance = n; });
  for (const int n : {0, 50, 200}) with(fmt::format("speckles {} px", n), [n](auto& p) { p.speckle_size = n; });
  for (const int n : {7, 9, 11, 13, 15, 21}) list.push_back({fmt::format("StereoBM {}x{}", n, n), block_matcher(n)});
  list.push_back({"StereoSGBM 5x5", semi_global_matcher()});
  return list;
}

// Left image, disparity (near red, far blue) and error (green to 0.5 px, yellow to 1, orange to 3, red beyond) of the
// first pair of each simulated world; black is unknown.
cv::Mat gallery(const Group& simulated, const Matcher& match, int frames_a_world) {
  cv::Mat all;
  for (std::size_t i = 0; i < simulated.pairs.size(); i += static_cast<std::size_t>(frames_a_world)) {
    const Pair& pair = simulated.pairs[i];
    const cv::Mat disparity = match(pair, simulated.disparities);
    cv::Mat left, near, grey, error(disparity.size(), CV_8UC3, cv::Scalar::all(0));
    cv::cvtColor(pair.left, left, cv::COLOR_GRAY2BGR);
    disparity.convertTo(grey, CV_8U, 255.0 / (16.0 * simulated.disparities));
    cv::applyColorMap(grey, near, cv::COLORMAP_TURBO);
    near.setTo(cv::Scalar::all(0), disparity < 0);
    for (int y = 0; y < disparity.rows; ++y) {
      for (int x = 0; x < disparity.cols; ++x) {
        const int d = disparity.at<std::int16_t>(y, x);
        const double truth = pair.truth.at<float>(y, x);
        if (d < 0 || !(truth > 0.0)) continue;
        const double off = std::abs(d / 16.0 - truth);
        auto& pixel = error.at<cv::Vec3b>(y, x);
        pixel = off <= 0.5   ? cv::Vec3b(80, 160, 60)
                : off <= 1.0 ? cv::Vec3b(60, 220, 240)
                : off <= 3.0 ? cv::Vec3b(30, 140, 250)
                             : cv::Vec3b(40, 40, 220);
      }
    }
    cv::Mat row;
    cv::hconcat(std::vector<cv::Mat>{left, near, error}, row);
    all.push_back(row);
  }
  cv::Mat small;
  cv::resize(all, small, {}, 0.5, 0.5, cv::INTER_AREA);
  return small;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Disparities beside the truth: every switch alone, and OpenCV's matchers"};
  std::string file, table, only, picture;
  int frames = 4;
  app.add_option("--json", file, "Write the results here");
  app.add_option("--table", table, "Write them here as a Markdown table as well");
  app.add_option("--gallery", picture, "Also a picture of what the shipped settings make of the simulated worlds");
  app.add_option("--only", only, "Candidates whose name contains this");
  app.add_option("--frames", frames, "Simulated frames a world")->capture_default_str();
  CLI11_PARSE(app, argc, argv);

  std::vector<Group> groups = recorded_groups();
  auto simulated = simulated_group(frames);
  if (!simulated) return tools::report(simulated.error());
  groups.push_back(std::move(*simulated));
  const std::vector<Candidate> all = candidates();
  if (!picture.empty() && !cv::imwrite(picture, gallery(groups.back(), all.front().match, frames))) {
    return tools::report({"cannot write the picture", picture, "check the folder and its rights"});
  }

  std::string head = "| |", rule = "| --- |";
  for (const Group& group : groups) {
    head += fmt::format(" {}: known % | wrong % | RMS px | fullest bin |", group.name);
    rule += " --- | --- | --- | --- |";
  }
  std::string text = head + "\n" + rule + "\n";
  fmt::print("{}", text);
  json results = json::array();
  for (const Candidate& candidate : all) {
    if (candidate.name.find(only) == std::string::npos) continue;
    std::string line = "| " + candidate.name + " |";
    json row{{"candidate", candidate.name}};
    for (const Group& group : groups) {
      Score score;
      for (const Pair& pair : group.pairs) score.add(pair, candidate.match(pair, group.disparities));
      const json r = score.result();
      row[group.name] = r;
      line += fmt::format(" {:.1f} | {:.2f} | {:.3f} | {:.2f} |", 100.0 * r["density"].get<double>(),
                          100.0 * r["wrong"].get<double>(), r["rms_px"].get<double>(), r["fullest_bin"].get<double>());
    }
    results.push_back(row);
    text += line + "\n";
    fmt::print("{}\n", line);
    std::fflush(stdout);
  }
  const auto write = [](const std::string& name, const std::string& content) {
    if (name.empty()) return true;
    std::ofstream out(name);
    out << content;
    return static_cast<bool>(out);
  };
  if (!write(file, results.dump(2) + "\n") || !write(table, text)) {
    return tools::report({"cannot write the results", file + " " + table, "check the folder and its rights"});
  }
  return tools::kDone;
}
