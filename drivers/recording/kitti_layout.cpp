// SPDX-License-Identifier: BSD-3-Clause
// KITTI odometry sequences (image_0, image_1, calib.txt, times.txt) and KITTI raw drives (image_00/data, ...); in
// colour image_2, image_3 and image_02, image_03.
#include <filesystem>
#include <fstream>

#include "drivers/calibration/calibration.h"
#include "drivers/recording/layout.h"
#include "drivers/recording/stamps.h"

namespace cliquevo::drivers {

namespace fs = std::filesystem;

namespace {

bool is_folder(const fs::path& path) {
  std::error_code ec;
  return fs::is_directory(path, ec);
}

// "P0:" and the like at the start of a line, in the first lines.
bool looks_like_kitti_calibration(const fs::path& file) {
  std::error_code ec;
  if (!fs::is_regular_file(file, ec)) return false;
  std::ifstream in(file);
  std::string line;
  for (int i = 0; i < 8 && std::getline(in, line); ++i) {
    if (line.size() > 3 && line[0] == 'P' && line[1] >= '0' && line[1] <= '3' && line[2] == ':') return true;
  }
  return false;
}

}  // namespace

namespace {

// In the drive's own folder, in the day's above it, or, for KITTI-360, in calibration/ beside data_2d_raw/.
std::string calibration_of_drive(const fs::path& drive) {
  std::error_code ec;
  fs::path at = fs::canonical(drive, ec);
  for (int up = 0; up < 3; ++up, at = at.parent_path()) {
    const fs::path perspective = at / "calibration" / "perspective.txt";
    if (fs::is_regular_file(perspective, ec)) return perspective.string();
    if (fs::is_regular_file(at / "perspective.txt", ec)) return (at / "perspective.txt").string();
    if (up == 2) break;
    if (std::string found = find_calibration(at.string()); !found.empty()) return found;
  }
  return {};
}

Result<std::optional<Layout>> find_drive(const fs::path& root, const std::string& images, const std::string& name) {
  for (const int first : {0, 2}) {
    const fs::path left = root / ("image_0" + std::to_string(first));
    const fs::path right = root / ("image_0" + std::to_string(first + 1));
    if (!is_folder(left / images) && !is_folder(right / images)) continue;
    Layout layout;
    layout.description = name + " " + root.string();
    layout.root = root.string();
    layout.left_camera = first;
    layout.right_camera = first + 1;
    if (const auto ok = list_both_sides(layout, (left / images).string(), (right / images).string()); !ok)
      return ok.error();
    std::string times = find_times(left.string());
    if (times.empty()) times = find_times(root.string());
    if (!times.empty()) {
      if (const auto ok = stamps_from_file(times, layout.left, layout.notes); !ok) return ok.error();
    }
    layout.calibration = calibration_of_drive(root);
    return std::optional<Layout>(std::move(layout));
  }
  return std::optional<Layout>{};
}

}  // namespace

Result<std::optional<Layout>> find_kitti_raw(const std::string& path) {
  auto found = find_drive(path, "data_rect", "KITTI-360 drive");
  if (!found || *found) return found;
  return find_drive(path, "data", "KITTI raw drive");
}

Result<std::optional<Layout>> find_kitti_odometry(const std::string& path) {
  const fs::path root(path);
  if (!looks_like_kitti_calibration(root / "calib.txt")) return std::optional<Layout>{};
  for (const int first : {0, 2}) {
    const fs::path left = root / ("image_" + std::to_string(first));
    const fs::path right = root / ("image_" + std::to_string(first + 1));
    if (!is_folder(left) && !is_folder(right)) continue;
    Layout layout;
    layout.description = "KITTI odometry folder " + path;
    layout.root = path;
    layout.left_camera = first;
    layout.right_camera = first + 1;
    layout.calibration = (root / "calib.txt").string();
    if (const auto ok = list_both_sides(layout, left.string(), right.string()); !ok) return ok.error();
    std::string times = find_times(path);
    if (times.empty()) {
      times = find_image_list(path, layout.left);
      if (!times.empty()) layout.notes.push_back("times from " + fs::path(times).filename().string());
    }
    if (!times.empty()) {
      if (const auto ok = stamps_from_file(times, layout.left, layout.notes); !ok) return ok.error();
    }
    return std::optional<Layout>(std::move(layout));
  }
  return std::optional<Layout>{};
}

}  // namespace cliquevo::drivers
