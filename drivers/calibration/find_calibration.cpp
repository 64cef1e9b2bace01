// SPDX-License-Identifier: BSD-3-Clause
// The calibration in a folder: a usual name, else whatever file is of a known format.
#include <algorithm>
#include <array>
#include <filesystem>
#include <iterator>
#include <vector>

#include <fmt/format.h>

#include "drivers/calibration/format.h"

namespace cliquevo::drivers {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLargestCandidate = 1U << 20U;
constexpr std::size_t kMostFiles = 200;  // of a folder, that are looked into

constexpr std::array<const char*, 39> kUsualNames{"calib_cam_to_cam.txt",
                                                  "perspective.txt",
                                                  "calib.txt",
                                                  "undistorted_calib_stereo.txt",
                                                  "camchain.yaml",
                                                  "kalibr_imucam_chain.yaml",
                                                  "stereo.yaml",
                                                  "stereo.yml",
                                                  "calibration.yaml",
                                                  "calibration.yml",
                                                  "calibration.json",
                                                  "calib.yaml",
                                                  "calib.yml",
                                                  "stereo_calib.yaml",
                                                  "stereo_calib.yml",
                                                  "stereo_calibration.yaml",
                                                  "stereo_calibration.yml",
                                                  "intrinsics.yml",
                                                  "intrinsics.yaml",
                                                  "extrinsics.yml",
                                                  "left.yaml",
                                                  "left.yml",
                                                  "camera_left.yaml",
                                                  "left_camera.yaml",
                                                  "left_camera_info.yaml",
                                                  "camera_info_left.yaml",
                                                  "cam0.yaml",
                                                  "cam0/sensor.yaml",
                                                  "mav0/cam0/sensor.yaml",
                                                  "left/sensor.yaml",
                                                  "left/camera_info.yaml",
                                                  "camera.txt",
                                                  "calibration.txt",
                                                  "ost.txt",
                                                  "ost.yaml",
                                                  "left.ini",
                                                  "right.yaml",
                                                  "cam1.yaml",
                                                  "cam1/sensor.yaml"};

std::string small_letters(std::string text) {
  for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return text;
}

// "stereoParams.mat": beside a recording it is looked at even if it is large, or cannot be read.
bool is_named_as_calibration(const fs::path& path) {
  const std::string name = small_letters(path.stem().string());
  const auto words = {"calib", "stereo", "param", "camera", "intrinsic", "extrinsic"};
  return std::any_of(words.begin(), words.end(), [&](const char* w) { return name.find(w) != std::string::npos; });
}

// How much a file looks like the calibration; the best of a folder count.
enum class Likeness { none, one_camera, printed, format };

Likeness likeness_of(const fs::path& path) {
  const std::string extension = path.extension().string();
  const auto known = {".yaml", ".yml", ".json", ".xml", ".conf", ".ini", ".txt", ".npz", ".m", ".toml"};
  if (std::find(known.begin(), known.end(), extension) == known.end()) return Likeness::none;
  std::error_code ec;
  const bool archive = extension == ".npz" && is_named_as_calibration(path);
  if (!fs::is_regular_file(path, ec)) return Likeness::none;
  if (!archive && fs::file_size(path, ec) > kLargestCandidate) return Likeness::none;
  Result<std::string> text = read_calibration_text(path.string());
  if (!text) return Likeness::none;
  const CalibrationText file(path.string(), std::move(*text));
  if (file.broken || (file.lines.empty() && !file.document)) return Likeness::none;
  const auto formats = calibration_formats();
  if (std::any_of(formats.begin(), formats.end(), [&](const CalibrationFormat& f) { return f.recognise(file); })) {
    return Likeness::format;
  }
  if (is_named_as_calibration(path) && names_printed_matrices(file)) return Likeness::printed;
  if (!file.document || !is_one_camera(file)) return Likeness::none;
  // One camera's file counts where all the rest is beside it: else a better one may lie above.
  const std::vector<std::string> others = other_camera_paths(path.string());
  const bool pair = std::any_of(others.begin(), others.end(), [&](const std::string& other) {
    return other != path.string() && fs::exists(other, ec);
  });
  CalibrationRequest request;
  request.path = path.string();
  return pair && read_calibration(request) ? Likeness::one_camera : Likeness::none;
}

std::string find_in(const std::string& folder) {
  std::error_code ec;
  for (const char* name : kUsualNames) {
    const fs::path file = fs::path(folder) / name;
    if (fs::exists(file, ec)) return file.string();
  }
  std::vector<std::string> chains;  // Kalibr puts the name of its recording into that of the file
  std::vector<std::string> files;
  Likeness best = Likeness::none;
  std::size_t seen = 0;
  for (fs::directory_iterator entry(folder, ec); !ec && entry != fs::directory_iterator(); entry.increment(ec)) {
    const std::string name = entry->path().filename().string();
    if (name.find("camchain") != std::string::npos && entry->path().extension() == ".yaml") {
      chains.push_back(entry->path().string());
    }
    if (++seen > kMostFiles) continue;
    const Likeness likeness = likeness_of(entry->path());
    if (likeness > best) files.clear();
    best = std::max(best, likeness);
    if (likeness == best && best != Likeness::none) files.push_back(entry->path().string());
  }
  if (!chains.empty()) return *std::min_element(chains.begin(), chains.end());
  // One file per camera is one calibration; the left camera's stands for it.
  const std::vector<std::string> all = files;
  files.erase(std::remove_if(files.begin(), files.end(),
                             [&all](const std::string& path) {
                               return std::any_of(all.begin(), all.end(),
                                                  [&](const std::string& other) { return is_right_of(path, other); });
                             }),
              files.end());
  if (files.empty()) return {};
  if (files.size() == 1) return files.front();
  // Beside other files (such as their pose alone) two that are named as a pair are the calibration.
  std::vector<std::string> pairs;
  std::copy_if(files.begin(), files.end(), std::back_inserter(pairs), [](const std::string& path) {
    const std::vector<std::string> others = other_camera_paths(path);
    std::error_code none;
    return std::any_of(others.begin(), others.end(), [&](const std::string& o) { return fs::exists(o, none); });
  });
  return pairs.size() == 1 ? pairs.front() : folder;
}

}  // namespace

std::optional<Error> binary_calibration(const std::string& path) {
  const std::string extension = small_letters(fs::path(path).extension().string());
  constexpr char kSavez[] =
      "write its matrices with np.savez('stereo_calibration.npz', K1=..., D1=..., K2=..., D2=..., R=..., T=...)";
  const bool pickle = extension == ".pkl" || extension == ".pickle" || extension == ".p";
  if (pickle) return Error{"calibration is a file of Python's own, no text", path, kSavez};
  if (extension == ".npy") return Error{"calibration is a single array of NumPy's, no text", path, kSavez};
  if (extension != ".mat") return std::nullopt;
  return Error{"calibration is a file of MATLAB's own, no text", path,
               "write its matrices as JSON (jsonencode), named K1, D1, K2, D2, R and T"};
}

Error missing_calibration(const std::string& recording) {
  std::error_code ec;
  const fs::path folder = fs::is_directory(recording, ec) ? fs::path(recording) : fs::path(recording).parent_path();
  std::size_t seen = 0;
  std::vector<std::string> binaries;
  for (const char* inner : {".", "calibration", "calib"}) {
    for (fs::directory_iterator entry(folder / inner, ec); !ec && entry != fs::directory_iterator();
         entry.increment(ec)) {
      if (++seen > kMostFiles) break;
      const std::string path = (inner[0] == '.' ? folder : folder / inner) / entry->path().filename();
      if (is_named_as_calibration(path) && binary_calibration(path)) binaries.push_back(path);
    }
  }
  if (!binaries.empty()) {
    const Error first = *binary_calibration(*std::min_element(binaries.begin(), binaries.end()));
    return {"recording has no calibration that can be read", first.where,
            fmt::format("it is no text: {}", first.remedy)};
  }
  return {"recording has no calibration", recording, "name one with --calibration FILE"};
}

std::string find_calibration(const std::string& folder) {
  std::string found = find_in(folder);
  std::error_code ec;
  for (const char* name : {"calibration", "Calibration", "calib", "camera_info"}) {
    const fs::path inner = fs::path(folder) / name;
    if (found.empty() && fs::is_directory(inner, ec)) found = find_in(inner.string());
  }
  return found;
}

}  // namespace cliquevo::drivers
