// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/layout.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>

namespace cliquevo::drivers {

namespace fs = std::filesystem;

namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

}  // namespace

bool is_image_name(const std::string& file) {
  static constexpr std::array<const char*, 9> kExtensions{".png", ".jpg",  ".jpeg", ".pgm", ".ppm",
                                                          ".bmp", ".tiff", ".tif",  ".webp"};
  std::string extension = fs::path(file).extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return std::find(kExtensions.begin(), kExtensions.end(), extension) != kExtensions.end();
}

bool natural_less(const std::string& a, const std::string& b) {
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      while (i < a.size() && a[i] == '0') ++i;
      while (j < b.size() && b[j] == '0') ++j;
      std::size_t ie = i;
      std::size_t je = j;
      while (ie < a.size() && is_digit(a[ie])) ++ie;
      while (je < b.size() && is_digit(b[je])) ++je;
      if (ie - i != je - j) return ie - i < je - j;
      const int order = a.compare(i, ie - i, b, j, je - j);
      if (order != 0) return order < 0;
      i = ie;
      j = je;
    } else {
      if (a[i] != b[j]) return a[i] < b[j];
      ++i;
      ++j;
    }
  }
  if (a.size() - i != b.size() - j) return a.size() - i < b.size() - j;
  return a < b;  // equal but for leading zeros
}

Result<Eye> list_eye(const std::string& folder) {
  Eye eye;
  eye.folder = folder;
  std::error_code ec;
  fs::directory_iterator entry(folder, ec);
  if (ec) return Error{"cannot list folder", folder, ec.message()};
  for (; entry != fs::directory_iterator(); entry.increment(ec)) {
    const fs::path file = entry->path();
    const std::string name = file.filename().string();
    if (name.front() == '.' || !is_image_name(name) || entry->is_directory(ec)) continue;
    eye.images.push_back({file.string(), file.stem().string(), std::nullopt});
  }
  if (ec) return Error{"cannot list folder", folder, ec.message()};
  if (eye.images.empty())
    return Error{"folder holds no images", folder, "copy the recording again (png, jpg, pgm, ...)"};
  std::sort(eye.images.begin(), eye.images.end(), [](const EyeImage& a, const EyeImage& b) {
    return a.name == b.name ? a.path < b.path : natural_less(a.name, b.name);
  });
  for (std::size_t i = 1; i < eye.images.size(); ++i) {
    if (eye.images[i].name == eye.images[i - 1].name) {
      return Error{"two images have the same name", eye.images[i].path, "keep one of the two file types"};
    }
  }
  return eye;
}

Result<void> list_eyes(Layout& layout, const std::string& left_folder, const std::string& right_folder) {
  std::error_code ec;
  for (const std::string& folder : {left_folder, right_folder}) {
    const bool left = folder == left_folder;
    if (!fs::is_directory(folder, ec)) {
      return Error{left ? "left eye is missing" : "right eye is missing", folder, "copy both eyes of the recording"};
    }
    Result<Eye> eye = list_eye(folder);
    if (!eye) return eye.error();
    (left ? layout.left : layout.right) = std::move(*eye);
  }
  return {};
}

Result<Layout> find_layout(const std::string& path) {
  std::error_code ec;
  if (path.empty()) return Error{"no such recording", "empty name", "name the folder that holds both eyes"};
  if (!fs::exists(path, ec)) return Error{"no such recording", path, "check the name of the folder"};
  if (!fs::is_directory(path, ec))
    return Error{"recording is no folder", path, "name the folder that holds both eyes, or an LCM event log"};
  for (const auto find : {find_euroc, find_kitti_raw, find_kitti_odometry, find_two_folders}) {
    Result<std::optional<Layout>> found = find(path);
    if (!found) return found.error();
    if (*found) return std::move(**found);
  }
  if (fs::is_empty(path, ec)) return Error{"recording folder is empty", path, "copy the recording again"};
  return Error{"no stereo recording", path,
               "expected KITTI (image_0, image_1 or image_00/data, image_01/data), EuRoC (mav0/cam0, mav0/cam1), two "
               "folders of images (left, right) or LCM logs (*.lcm)"};
}

}  // namespace cliquevo::drivers
