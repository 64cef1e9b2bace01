// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/layout.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <system_error>

#include "drivers/calibration/calibration.h"
#include "drivers/recording/letters.h"

namespace cliquevo::drivers {

namespace fs = std::filesystem;

bool same_names(const ImageList& a, const ImageList& b) {
  return std::equal(a.images.begin(), a.images.end(), b.images.begin(), b.images.end(),
                    [](const RecordedImage& x, const RecordedImage& y) { return x.name == y.name; });
}

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

Result<ImageList> list_images(const std::string& folder) {
  ImageList list;
  list.folder = folder;
  std::error_code ec;
  fs::directory_iterator entry(folder, ec);
  if (ec) return Error{"cannot list folder", folder, ec.message()};
  for (; entry != fs::directory_iterator(); entry.increment(ec)) {
    const fs::path file = entry->path();
    const std::string name = file.filename().string();
    if (name.front() == '.' || !is_image_name(name) || entry->is_directory(ec)) continue;
    list.images.push_back({file.string(), file.stem().string(), std::nullopt});
  }
  if (ec) return Error{"cannot list folder", folder, ec.message()};
  if (list.images.empty())
    return Error{"folder holds no images", folder, "copy the recording again (png, jpg, pgm, ...)"};
  std::sort(list.images.begin(), list.images.end(), [](const RecordedImage& a, const RecordedImage& b) {
    return a.name == b.name ? a.path < b.path : natural_less(a.name, b.name);
  });
  for (std::size_t i = 1; i < list.images.size(); ++i) {
    if (list.images[i].name == list.images[i - 1].name) {
      return Error{"two images have the same name", list.images[i].path, "keep one of the two file types"};
    }
  }
  return list;
}

Result<void> list_both_sides(Layout& layout, const std::string& left_folder, const std::string& right_folder) {
  std::error_code ec;
  for (const std::string& folder : {left_folder, right_folder}) {
    const bool left = folder == left_folder;
    if (!fs::is_directory(folder, ec)) {
      return Error{left ? "left images are missing" : "right images are missing", folder,
                   "copy both folders of the recording"};
    }
    Result<ImageList> list = list_images(folder);
    if (!list) return list.error();
    (left ? layout.left : layout.right) = std::move(*list);
  }
  return {};
}

namespace {

bool has_images(const fs::path& folder) {
  std::error_code ec;
  for (fs::directory_iterator entry(folder, ec); !ec && entry != fs::directory_iterator(); entry.increment(ec)) {
    const std::string name = entry->path().filename().string();
    if (name.front() != '.' && is_image_name(name) && !entry->is_directory(ec)) return true;
  }
  return false;
}

constexpr std::size_t kMostWithImages = 300;
constexpr std::size_t kMostFolders = 5000;  // visited: somebody may name the root of a disk

void collect(const fs::path& folder, std::vector<std::string>& parts, int depth, std::size_t& visited,
             std::vector<ImageFolder>& out) {
  if (++visited > kMostFolders || out.size() >= kMostWithImages) return;
  if (has_images(folder)) out.push_back({parts, folder.string()});
  if (depth == 0) return;
  std::vector<std::string> names;
  std::error_code ec;
  for (fs::directory_iterator entry(folder, ec); !ec && entry != fs::directory_iterator(); entry.increment(ec)) {
    std::string name = entry->path().filename().string();
    std::error_code ignored;
    if (name.front() != '.' && entry->is_directory(ignored)) names.push_back(std::move(name));
  }
  std::sort(names.begin(), names.end(), natural_less);
  for (const std::string& name : names) {
    parts.push_back(name);
    collect(folder / name, parts, depth - 1, visited, out);
    parts.pop_back();
  }
}

// "12 images in frames, 4 in depth; folders a, b" for a message, not too long.
std::string what_is_there(const std::string& path) {
  constexpr std::size_t kMostNames = 6;
  std::string out;
  const std::vector<ImageFolder> folders = folders_with_images(path, 5);
  for (std::size_t i = 0; i < std::min(folders.size(), kMostNames); ++i) {
    const Result<ImageList> list = list_images(folders[i].path);
    std::string name;
    for (const std::string& part : folders[i].parts) name += (name.empty() ? "" : "/") + part;
    if (!out.empty()) out += ", ";
    out += list ? std::to_string(list->images.size()) + " images" : "images";
    out += " in " + (name.empty() ? "it" : name);
  }
  if (folders.size() > kMostNames)
    out += ", and " + std::to_string(folders.size() - kMostNames) + " more folders of images";
  return out.empty() ? "no image in it, nor five levels down" : out;
}

}  // namespace

std::vector<ImageFolder> folders_with_images(const std::string& path, int depth) {
  std::vector<ImageFolder> out;
  std::vector<std::string> parts;
  std::size_t visited = 0;
  collect(path, parts, depth, visited, out);
  return out;
}

std::string calibration_between(const std::string& folder, const std::string& top) {
  std::error_code ec;
  const fs::path last = fs::weakly_canonical(top, ec);
  for (fs::path at = fs::weakly_canonical(folder, ec);; at = at.parent_path()) {
    if (std::string found = find_calibration(at.string()); !found.empty()) return found;
    for (const char* name : {"calibration", "calib", "calibrations", "calibs", "params", "config"}) {
      if (!fs::is_directory(at / name, ec)) continue;
      if (std::string found = find_calibration((at / name).string()); !found.empty()) return found;
    }
    if (at == last || at == at.parent_path()) return {};
  }
}

// Each in its own file.
Result<std::optional<Layout>> find_euroc(const std::string& path);
Result<std::optional<Layout>> find_kitti_raw(const std::string& path);
Result<std::optional<Layout>> find_kitti_odometry(const std::string& path);
Result<std::optional<Layout>> find_two_folders(const std::string& path);
Result<std::optional<Layout>> find_names_in_one_folder(const std::string& path);
Result<std::optional<Layout>> find_side_by_side(const std::string& path);  // where the halves are seen to match
Result<std::optional<Layout>> find_single_side(const std::string& path);   // only ever an error: the other is missing

// The more particular before find_two_folders, which takes nearly anything.
const std::vector<LayoutKind>& layout_kinds() {
  static const std::vector<LayoutKind> kinds{
      {"EuRoC (mav0/cam0, mav0/cam1)", find_euroc},
      {"KITTI raw and KITTI-360 (image_00/data, image_01/data; image_00/data_rect, ...)", find_kitti_raw},
      {"KITTI odometry (image_0, image_1, calib.txt)", find_kitti_odometry},
      {"two folders, up to five levels down, whose names differ in left/right, l/r, 0/1, 1/2 or the like",
       find_two_folders},
      {"one folder with images whose names differ so", find_names_in_one_folder},
      {"side-by-side images, where their halves match (or --side-by-side says so)", find_side_by_side},
      // No layout: names the missing side. Its text stands for logs, which recording.cpp opens.
      {"LCM logs (*.lcm)", find_single_side}};
  return kinds;
}

Result<Layout> find_layout(const std::string& path, bool side_by_side) {
  std::error_code ec;
  if (path.empty()) return Error{"no such recording", "empty name", "name the folder that holds the images of both"};
  if (!fs::exists(path, ec)) return Error{"no such recording", path, "check the name of the folder"};
  if (!fs::is_directory(path, ec))
    return Error{"recording is no folder", path, "name the folder that holds the images of both, or an LCM event log"};
  if (fs::is_empty(path, ec)) return Error{"recording folder is empty", path, "copy the recording again"};
  if (side_by_side) return read_side_by_side(path);
  std::string looked_for;
  for (const LayoutKind& kind : layout_kinds()) {
    Result<std::optional<Layout>> found = kind.find(path);
    if (!found) return found.error();
    if (*found) return std::move(**found);
    looked_for += (looked_for.empty() ? "" : "; ") + std::string(kind.looks_like);
  }
  return Error{"no stereo recording", path, "found " + what_is_there(path) + "; looked for " + looked_for};
}

}  // namespace cliquevo::drivers
