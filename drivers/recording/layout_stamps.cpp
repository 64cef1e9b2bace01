// SPDX-License-Identifier: BSD-3-Clause
// Which times file belongs to the images of a layout: one beside each camera's images, or one for both.
#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

#include "drivers/recording/layout.h"
#include "drivers/recording/stamps.h"

namespace cliquevo::drivers {

namespace fs = std::filesystem;

namespace {

// In the folder of a camera's images, or beside it under its name.
std::string times_of(const fs::path& folder) {
  std::error_code ec;
  if (fs::is_regular_file(folder / "data.csv", ec)) return (folder / "data.csv").string();
  if (std::string times = find_times(folder.string()); !times.empty()) return times;
  const std::string name = folder.filename().string();
  if (name == "data" && fs::is_regular_file(folder.parent_path() / "data.csv", ec)) {
    return (folder.parent_path() / "data.csv").string();
  }
  const fs::path beside = folder.parent_path() / (name + ".timestamps");
  if (fs::is_regular_file(beside, ec)) return beside.string();
  for (const char* word : {"times", "timestamps", "timestamp"}) {
    for (const char* extension : {".txt", ".csv"}) {
      for (const std::string& file :
           {fmt::format("{}_{}{}", name, word, extension), fmt::format("{}_{}{}", word, name, extension)}) {
        if (fs::is_regular_file(folder.parent_path() / file, ec)) return (folder.parent_path() / file).string();
      }
    }
  }
  return {};
}

// A list that names the camera's images, in the folder that both share or above it, up to the one above the recording.
std::string list_of(const ImageList& camera, const std::string& shared, const fs::path& last) {
  for (fs::path at = shared;; at = at.parent_path()) {
    if (std::string list = find_image_list(at.string(), camera); !list.empty()) return list;
    if (at == last.parent_path() || at == at.parent_path()) return {};
  }
}

// From the images' folder up to, but without, the folder that both cameras share.
std::string own_times(const std::string& folder, const std::string& shared) {
  std::error_code ec;
  const fs::path top = fs::weakly_canonical(shared, ec);
  for (fs::path at = fs::weakly_canonical(folder, ec); at != top && at != at.parent_path(); at = at.parent_path()) {
    if (std::string times = times_of(at); !times.empty()) return times;
  }
  return {};
}

std::string shared_folder(const Layout& layout) {
  std::error_code ec;
  fs::path left = fs::weakly_canonical(layout.left.folder, ec);
  const fs::path right = fs::weakly_canonical(layout.right.folder, ec);
  if (left == right) return left.string();
  while (left != left.parent_path()) {
    left = left.parent_path();
    const auto end = std::mismatch(left.begin(), left.end(), right.begin(), right.end()).first;
    if (end == left.end()) break;
  }
  return left.string();
}

}  // namespace

Result<void> find_stamps(Layout& layout, const std::string& top) {
  const std::string shared = shared_folder(layout);
  const std::string left_times = own_times(layout.left.folder, shared);
  const std::string right_times = own_times(layout.right.folder, shared);
  if (!left_times.empty() && !right_times.empty()) {
    if (auto ok = stamps_from_file(left_times, layout.left, layout.notes); !ok) return ok;
    std::vector<std::string> said_already;
    return stamps_from_file(right_times, layout.right, said_already);
  }
  // One list of times serves both cameras only where the names show which images belong together.
  std::string times = left_times;
  std::error_code ec;
  const fs::path last = fs::weakly_canonical(top, ec);
  for (fs::path at = shared; times.empty(); at = at.parent_path()) {
    times = times_of(at);
    if (at == last || at == at.parent_path()) break;
  }
  const bool same = same_names(layout.left, layout.right);
  if (same && !times.empty()) return stamps_from_file(times, layout.left, layout.notes);
  std::vector<std::string> notes;
  if (stamps_from_names(layout.left, notes)) {
    layout.notes.insert(layout.notes.end(), notes.begin(), notes.end());
    if (!layout.side_by_side) stamps_from_names(layout.right, notes);
    return {};
  }
  if (!times.empty()) return stamps_from_file(times, layout.left, layout.notes);
  const std::string left_list = list_of(layout.left, shared, last);
  if (left_list.empty()) return {};
  layout.notes.push_back("times from " + fs::path(left_list).filename().string());
  if (auto ok = stamps_from_file(left_list, layout.left, layout.notes); !ok || same) return ok;
  const std::string right_list = list_of(layout.right, shared, last);
  return right_list.empty() ? Result<void>{} : stamps_from_file(right_list, layout.right, notes);
}

}  // namespace cliquevo::drivers
