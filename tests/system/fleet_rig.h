// SPDX-License-Identifier: BSD-3-Clause
// Fleets of small simulated recordings, and what they leave on disk.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {

// A tenth of a second on one core, once its course was rendered ($CLIQUEVO_CACHE): seeds differ in noise alone.
inline std::string small_course(int seed, int frames = 20) {
  return fmt::format("sim:width=160,height=120,focal_px=175,frames={},noise_seed={}", frames, seed);
}

inline std::vector<std::string> small_courses(int count, int frames = 20) {
  std::vector<std::string> out;
  for (int seed = 1; seed <= count; ++seed) out.push_back(small_course(seed, frames));
  return out;
}

// cliquevo fleet COMMAND --out FOLDER WORDS
inline Finished fleet(const std::string& command, const std::string& folder, const std::vector<std::string>& words = {},
                      const Environment& environment = {}) {
  std::vector<std::string> all{binary("cliquevo"), "fleet", command, "--out", folder};
  all.insert(all.end(), words.begin(), words.end());
  return run(all, environment);
}

// Below a fleet's folder, the files with this ending: name, content.
inline std::map<std::string, std::string> files_ending(const std::string& folder, const std::string& ending) {
  std::map<std::string, std::string> out;
  std::error_code none;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder + "/results", none)) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with(ending)) out[name] = read_file(entry.path().string());
  }
  return out;
}
inline std::map<std::string, std::string> results_in(const std::string& folder) {
  return files_ending(folder, ".result.json");
}

inline nlohmann::json report_of(const std::string& folder) {
  return nlohmann::json::parse(read_file(folder + "/report.json"), nullptr, false);
}

}  // namespace cliquevo::test
