// SPDX-License-Identifier: BSD-3-Clause
// Two folders of images side by side, by their usual names.
#include <array>
#include <filesystem>
#include <utility>

#include "drivers/calibration/calibration.h"
#include "drivers/recording/layout.h"
#include "drivers/recording/stamps.h"

namespace cliquevo::drivers {

namespace fs = std::filesystem;

namespace {

constexpr std::array<std::pair<const char*, const char*>, 22> kNames{{
    {"left", "right"},
    {"Left", "Right"},
    {"image_0", "image_1"},
    {"image_00", "image_01"},
    {"cam0", "cam1"},
    {"image_2", "image_3"},
    {"image_02", "image_03"},
    {"image_left", "image_right"},
    {"images_left", "images_right"},
    {"left_images", "right_images"},
    {"left_image", "right_image"},
    {"img_left", "img_right"},
    {"cam_left", "cam_right"},
    {"left_cam", "right_cam"},
    {"camera_left", "camera_right"},
    {"camera0", "camera1"},
    {"camera_0", "camera_1"},
    {"cam_0", "cam_1"},
    {"image0", "image1"},
    {"infra1", "infra2"},
    {"l", "r"},
    {"0", "1"},
}};

bool is_folder(const fs::path& path) {
  std::error_code ec;
  return fs::is_directory(path, ec);
}

// The eye's images may lie one folder deeper.
std::string image_folder(const fs::path& eye) { return (is_folder(eye / "data") ? eye / "data" : eye).string(); }

// A times file of this eye alone: in its folder, or beside it.
std::string own_times(const fs::path& eye) {
  std::error_code ec;
  if (fs::exists(eye / "data.csv", ec)) return (eye / "data.csv").string();
  if (std::string times = find_times(eye.string()); !times.empty()) return times;
  for (const char* pattern : {"_times.txt", "_timestamps.txt"}) {
    const fs::path beside = eye.parent_path() / (eye.filename().string() + pattern);
    if (fs::exists(beside, ec)) return beside.string();
  }
  return {};
}

bool same_names(const Eye& a, const Eye& b) {
  if (a.images.size() != b.images.size()) return false;
  for (std::size_t i = 0; i < a.images.size(); ++i) {
    if (a.images[i].name != b.images[i].name) return false;
  }
  return true;
}

Result<void> find_stamps(Layout& layout, const fs::path& left, const fs::path& right) {
  const std::string left_times = own_times(left);
  const std::string right_times = own_times(right);
  if (!left_times.empty() && !right_times.empty()) {
    if (auto ok = stamps_from_file(left_times, layout.left); !ok) return ok;
    return stamps_from_file(right_times, layout.right);
  }
  // One list of times serves both eyes only where the names say which images belong together.
  const std::string times = left_times.empty() ? find_times(layout.root) : left_times;
  if (same_names(layout.left, layout.right) && !times.empty()) return stamps_from_file(times, layout.left);
  if (stamps_from_names(layout.left)) {
    stamps_from_names(layout.right);
    return {};
  }
  return times.empty() ? Result<void>{} : stamps_from_file(times, layout.left);
}

}  // namespace

Result<std::optional<Layout>> find_two_folders(const std::string& path) {
  const fs::path root(path);
  for (const bool both : {true, false}) {  // a whole pair first: "left" alone beside image_0 and image_1 is no eye
    for (const auto& [left_name, right_name] : kNames) {
      const fs::path left = root / left_name;
      const fs::path right = root / right_name;
      if (both ? !(is_folder(left) && is_folder(right)) : !(is_folder(left) || is_folder(right))) continue;
      Layout layout;
      layout.description = "two folders of images in " + path;
      layout.root = path;
      if (auto ok = list_eyes(layout, image_folder(left), image_folder(right)); !ok) return ok.error();
      if (auto ok = find_stamps(layout, left, right); !ok) return ok.error();
      layout.calibration = find_calibration(path);
      return std::optional<Layout>(std::move(layout));
    }
  }
  return std::optional<Layout>{};
}

}  // namespace cliquevo::drivers
