// SPDX-License-Identifier: BSD-3-Clause
// Names of calibration files that are one camera's: the other camera's file, and which of both is the left one's.
#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

#include "drivers/calibration/format.h"

namespace cliquevo::drivers {

namespace {

namespace fs = std::filesystem;

// In the order in which a file of the other camera is looked for.
constexpr std::array<std::pair<const char*, const char*>, 21> kSideWords{
    {{"left", "right"},        {"Left", "Right"},  {"LEFT", "RIGHT"},      {"cam0", "cam1"},   {"camera0", "camera1"},
     {"camera_0", "camera_1"}, {"cam_0", "cam_1"}, {"infra1", "infra2"},   {"cam1", "cam2"},   {"camera1", "camera2"},
     {"camera_1", "camera_2"}, {"cam_1", "cam_2"}, {"sensor0", "sensor1"}, {"gray0", "gray1"}, {"mono0", "mono1"},
     {"/l.", "/r."},           {"/L.", "/R."},     {"_l.", "_r."},         {"_L.", "_R."},     {"camL", "camR"},
     {"cam_L", "cam_R"}}};

enum class Side { none, left, right };

// By the word in a file's own name.
Side side_of(const fs::path& path) {
  std::string name = path.filename().string();
  for (char& c : name) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  const bool left = name.find("left") != std::string::npos;
  const bool right = name.find("right") != std::string::npos;
  return left == right ? Side::none : left ? Side::left : Side::right;
}

// The only file of the other side in the folder, whatever else its name holds (ROS writes serial numbers); empty =
// none.
std::string only_other_side(const std::string& path) {
  constexpr int kMostFiles = 200;
  const Side side = side_of(path);
  if (side == Side::none) return {};
  std::string found;
  std::error_code ec;
  const fs::path folder = fs::path(path).parent_path();
  int seen = 0;
  for (fs::directory_iterator entry(folder.empty() ? "." : folder, ec);
       !ec && entry != fs::directory_iterator() && ++seen <= kMostFiles; entry.increment(ec)) {
    const fs::path& candidate = entry->path();
    if (candidate.extension() != fs::path(path).extension()) continue;
    const Side other = side_of(candidate);
    if (other == side && candidate.filename() != fs::path(path).filename()) return {};
    if (other == Side::none || other == side) continue;
    if (!found.empty()) return {};
    found = (folder / candidate.filename()).string();
  }
  return found;
}

}  // namespace

std::string replaced(const std::string& path, const std::string& from, const std::string& to, int depth) {
  std::size_t begin = path.size();
  for (int i = 0; i < depth && begin != std::string::npos && begin > 0; ++i) begin = path.rfind('/', begin - 1);
  if (begin == std::string::npos) begin = 0;
  const std::size_t at = path.rfind(from);
  if (at == std::string::npos || at < begin) return {};
  std::string out = path;
  return out.replace(at, from.size(), to);
}

std::string beside(const std::string& path, const std::string& name) {
  return (fs::path(path).parent_path() / name).string();
}

std::vector<std::string> other_camera_paths(const std::string& path) {
  std::vector<std::string> out;
  for (const auto& [left, right] : kSideWords) {
    for (const std::string& name : {replaced(path, left, right, 2), replaced(path, right, left, 2)}) {
      if (!name.empty()) out.push_back(name);
    }
  }
  if (std::string other = only_other_side(path); !other.empty()) out.push_back(std::move(other));
  return out;
}

bool is_right_of(const std::string& path, const std::string& other) {
  const bool by_names = fs::path(path).parent_path() == fs::path(other).parent_path() && side_of(path) == Side::right &&
                        side_of(other) == Side::left;
  return by_names || std::any_of(kSideWords.begin(), kSideWords.end(), [&](const auto& words) {
           return replaced(path, words.second, words.first, 2) == other;
         });
}

}  // namespace cliquevo::drivers
