// SPDX-License-Identifier: BSD-3-Clause
// Tells the calibration formats apart by what is in the file, and finds the file of the other eye where there are two.
#include "drivers/calibration_file.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

#include "drivers/recording/calibration_common.h"
#include "drivers/recording/dso_calibration.h"
#include "drivers/recording/kitti_calibration.h"
#include "drivers/recording/text_file.h"
#include "drivers/recording/yaml_calibration.h"

namespace cliquevo::drivers {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostBytes = 1U << 20U;

bool has_key(const std::vector<TextLine>& lines, std::string_view key) {
  for (const TextLine& line : lines) {
    if (line.text.substr(0, key.size()) == key && trim(line.text.substr(key.size())).substr(0, 1) == ":") return true;
  }
  return false;
}

bool is_yaml(const std::string& path, const std::string& text) {
  const std::string extension = fs::path(path).extension().string();
  if (extension == ".yaml" || extension == ".yml" || extension == ".json" || text.compare(0, 5, "%YAML") == 0) {
    return true;
  }
  const std::vector<TextLine> lines = split_lines(text);
  const auto known = {"cam0", "T_BS", "camera_matrix", "image_width", "distortion_model", "K1", "M1", "cameraMatrix1"};
  return std::any_of(known.begin(), known.end(), [&](const char* key) { return has_key(lines, key); });
}

Result<StereoCalibration> parse_lines(const std::string& text, const CalibrationRequest& request) {
  const std::vector<TextLine> lines = split_lines(text);
  for (const char* key : {"calib_time", "K_00", "S_00", "K_02", "S_02", "R_rect_00", "P_rect_00"}) {
    if (has_key(lines, key)) return parse_kitti_raw(text, request);
  }
  for (const char* key : {"P0", "P1", "P2", "P3"}) {
    if (has_key(lines, key)) return parse_kitti_odometry(text, request);
  }
  return parse_dso(text, request);
}

Result<YamlReader> parse_other(const SecondFile& second, FilePair kind) {
  const Result<NamedText> other = second(kind);
  if (!other) return other.error();
  return YamlReader::parse(other->text, other->path);
}

using ParsePair = Result<StereoCalibration> (*)(const YamlReader&, const YamlReader&, const CalibrationRequest&);

// One file an eye; whichever was named, the other is found.
Result<StereoCalibration> parse_eyes(const YamlReader& named, const std::string& path, const SecondFile& second,
                                     ParsePair parse, const CalibrationRequest& request) {
  const Result<YamlReader> other = parse_other(second, FilePair::eyes);
  if (!other) return other.error();
  const bool swapped = is_right_eye(path);
  return swapped ? parse(*other, named, request) : parse(named, *other, request);
}

// Last occurrence of `from` in the last `depth` components of the path, replaced.
std::string replaced(const std::string& path, const std::string& from, const std::string& to, int depth) {
  std::size_t begin = path.size();
  for (int i = 0; i < depth && begin != std::string::npos && begin > 0; ++i) begin = path.rfind('/', begin - 1);
  if (begin == std::string::npos) begin = 0;
  const std::size_t at = path.rfind(from);
  if (at == std::string::npos || at < begin) return {};
  std::string out = path;
  return out.replace(at, from.size(), to);
}

constexpr std::array<std::pair<const char*, const char*>, 6> kEyeWords{{{"left", "right"},
                                                                        {"Left", "Right"},
                                                                        {"LEFT", "RIGHT"},
                                                                        {"cam0", "cam1"},
                                                                        {"camera0", "camera1"},
                                                                        {"camera_0", "camera_1"}}};

// The file beside (or in the folder beside) `path` that belongs to it.
Result<NamedText> read_second(const std::string& path, FilePair kind) {
  std::error_code ec;
  std::vector<std::string> candidates;
  if (kind == FilePair::eyes) {
    for (const auto& [left, right] : kEyeWords) {
      candidates.push_back(replaced(path, left, right, 2));
      candidates.push_back(replaced(path, right, left, 2));
    }
  } else {
    candidates.push_back(replaced(path, "intrinsics", "extrinsics", 1));
    candidates.push_back(replaced(path, "extrinsics", "intrinsics", 1));
  }
  candidates.erase(std::remove(candidates.begin(), candidates.end(), std::string{}), candidates.end());
  for (const std::string& candidate : candidates) {
    if (!fs::exists(candidate, ec)) continue;
    Result<std::string> text = read_text_file(candidate, "calibration", kMostBytes);
    if (!text) return text.error();
    return NamedText{candidate, std::move(*text)};
  }
  if (kind == FilePair::parts) return Error{"calibration lacks R and T between the eyes", path, "name the stereo file"};
  return Error{"calibration of the other eye is missing", candidates.empty() ? path : candidates.front(),
               "put both beside each other, named left and right or cam0 and cam1"};
}

}  // namespace

bool is_right_eye(const std::string& path) {
  return std::any_of(kEyeWords.begin(), kEyeWords.end(), [&](const auto& words) {
    return replaced(path, words.first, words.second, 2).empty() &&
           !replaced(path, words.second, words.first, 2).empty();
  });
}

Result<StereoCalibration> parse_calibration(const std::string& text, const CalibrationRequest& request,
                                            const SecondFile& second) {
  if (!is_yaml(request.path, text)) return parse_lines(text, request);
  const Result<YamlReader> yaml = YamlReader::parse(text, request.path);
  if (!yaml) return yaml.error();
  if (is_kalibr(*yaml)) return parse_kalibr(*yaml, request);
  if (is_euroc(*yaml)) return parse_eyes(*yaml, request.path, second, parse_euroc, request);
  const bool intrinsics = has_opencv_intrinsics(*yaml);
  const bool extrinsics = has_opencv_extrinsics(*yaml);
  if (intrinsics && extrinsics) return parse_opencv(*yaml, *yaml, request);
  if (is_ros(*yaml)) return parse_eyes(*yaml, request.path, second, parse_ros, request);
  if (intrinsics || extrinsics) {
    const Result<YamlReader> other = parse_other(second, FilePair::parts);
    if (!other) return other.error();
    return intrinsics ? parse_opencv(*yaml, *other, request) : parse_opencv(*other, *yaml, request);
  }
  return Error{"calibration is of no known format", request.path,
               "name a KITTI, EuRoC, Kalibr, ROS camera_info, OpenCV stereo or DSO stereo file"};
}

std::string find_calibration(const std::string& folder) {
  static constexpr std::array<const char*, 34> kNames{"calib_cam_to_cam.txt",
                                                      "calib.txt",
                                                      "calib_stereo.txt",
                                                      "camchain.yaml",
                                                      "stereo.yaml",
                                                      "stereo.yml",
                                                      "calibration.yaml",
                                                      "calibration.yml",
                                                      "calib.yaml",
                                                      "calib.yml",
                                                      "stereo_calib.yaml",
                                                      "stereo_calib.yml",
                                                      "calib_stereo.yaml",
                                                      "calib_stereo.yml",
                                                      "stereo_calibration.yaml",
                                                      "stereo_calibration.yml",
                                                      "left.yaml",
                                                      "left.yml",
                                                      "cam0.yaml",
                                                      "cam0.yml",
                                                      "left_camera_info.yaml",
                                                      "camera_info_left.yaml",
                                                      "left_info.yaml",
                                                      "left/camera_info.yaml",
                                                      "cam0/sensor.yaml",
                                                      "mav0/cam0/sensor.yaml",
                                                      "left/sensor.yaml",
                                                      "extrinsics.yml",
                                                      "extrinsics.yaml",
                                                      "camera.txt",
                                                      "calibration.txt",
                                                      "right.yaml",
                                                      "cam1.yaml",
                                                      "cam1/sensor.yaml"};
  std::error_code ec;
  for (const char* name : kNames) {
    const fs::path file = fs::path(folder) / name;
    if (fs::exists(file, ec)) return file.string();
  }
  // Kalibr puts the name of its recording into that of the file.
  std::vector<std::string> chains;
  for (fs::directory_iterator entry(folder, ec); !ec && entry != fs::directory_iterator(); entry.increment(ec)) {
    const std::string name = entry->path().filename().string();
    if (name.find("camchain") != std::string::npos && entry->path().extension() == ".yaml") {
      chains.push_back(entry->path().string());
    }
  }
  return chains.empty() ? std::string{} : *std::min_element(chains.begin(), chains.end());
}

Result<StereoCalibration> read_calibration(const CalibrationRequest& request) {
  std::error_code ec;
  CalibrationRequest file = request;
  if (fs::is_directory(request.path, ec)) {
    file.path = find_calibration(request.path);
    if (file.path.empty())
      return Error{"folder holds no calibration", request.path, "name the file with --calibration"};
  }
  const Result<std::string> text = read_text_file(file.path, "calibration", kMostBytes);
  if (!text) return text.error();
  return parse_calibration(*text, file, [&](FilePair kind) { return read_second(file.path, kind); });
}

Result<StereoCalibration> read_calibration(const std::string& path, int width, int height) {
  CalibrationRequest request;
  request.path = path;
  request.width = width;
  request.height = height;
  return read_calibration(request);
}

}  // namespace cliquevo::drivers
