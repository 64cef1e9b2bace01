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
constexpr std::array<std::pair<const char*, const char*>, 16> kSideWords{{{"left", "right"},
                                                                          {"Left", "Right"},
                                                                          {"LEFT", "RIGHT"},
                                                                          {"cam0", "cam1"},
                                                                          {"camera0", "camera1"},
                                                                          {"camera_0", "camera_1"},
                                                                          {"cam_0", "cam_1"},
                                                                          {"infra1", "infra2"},
                                                                          {"cam1", "cam2"},
                                                                          {"camera1", "camera2"},
                                                                          {"camera_1", "camera_2"},
                                                                          {"cam_1", "cam_2"},
                                                                          {"_l.", "_r."},
                                                                          {"_L.", "_R."},
                                                                          {"camL", "camR"},
                                                                          {"cam_L", "cam_R"}}};

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
  return out;
}

bool is_right_of(const std::string& path, const std::string& other) {
  return std::any_of(kSideWords.begin(), kSideWords.end(),
                     [&](const auto& words) { return replaced(path, words.second, words.first, 2) == other; });
}

}  // namespace cliquevo::drivers
