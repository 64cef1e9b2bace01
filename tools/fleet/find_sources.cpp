// SPDX-License-Identifier: BSD-3-Clause
// Which recordings the words of a command line mean.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <glob.h>
#include <map>
#include <set>
#include <system_error>

#include <fmt/format.h>

#include "tools/fleet/make_plan.h"
#include "tools/fleet/unit_key.h"
#include "tools/source_argument.h"

namespace cliquevo::tools::fleet {

namespace fs = std::filesystem;

namespace {

std::string absolute(const std::string& path) {
  std::error_code error;
  // LEFT,RIGHT of two videos: each of them.
  if (const std::size_t comma = path.find(','); comma != std::string::npos && !fs::exists(path, error)) {
    return absolute(path.substr(0, comma)) + "," + absolute(path.substr(comma + 1));
  }
  std::string out = fs::absolute(path, error).lexically_normal().string();
  while (out.size() > 1 && out.back() == '/') out.pop_back();
  return out;
}

// Its calibration may be named by the configuration alone.
bool opens(const std::string& path) {
  daemon::Config config = daemon::default_config();
  config.source.recording.needs_calibration = false;
  return open_unit_source(path, config).ok();
}

// What is in a folder of recordings: all folders in it, and the files among them that are recordings. A folder that
// cannot be read is among them, for the report to name it.
struct Inside {
  std::vector<std::string> all;
  std::size_t folders = 0;  // that are recordings by themselves
  std::size_t good = 0;     // files too
};

Inside look_inside(const std::string& folder) {
  Inside out;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
    const std::string path = entry->path().string();
    if (entry->path().filename().string().starts_with('.')) continue;
    std::error_code none;
    const bool is_folder = entry->is_directory(none);
    const bool good = opens(path);
    out.good += good ? 1 : 0;
    out.folders += good && is_folder ? 1 : 0;
    if (good || is_folder) out.all.push_back(path);
  }
  std::sort(out.all.begin(), out.all.end());
  return out;
}

Result<std::vector<std::string>> matches(const std::string& pattern) {
  glob_t found{};
  std::vector<std::string> out;
  if (::glob(pattern.c_str(), GLOB_TILDE, nullptr, &found) == 0) {
    for (std::size_t k = 0; k < found.gl_pathc; ++k) out.emplace_back(found.gl_pathv[k]);
  }
  ::globfree(&found);
  if (out.empty()) return Error{"nothing matches", pattern, "see where the recordings are"};
  return out;
}

Result<std::vector<std::string>> lines_of_file(const std::string& path) {
  std::ifstream file(path);
  if (!file) return Error{"cannot read the list of recordings", path, "name a file with a source a line: @FILE"};
  std::vector<std::string> out;
  for (std::string line; std::getline(file, line);) {
    while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.pop_back();
    if (!line.empty() && line.front() != '#') out.push_back(line);
  }
  return out;
}

Result<std::vector<std::string>> expand(const std::string& source) {
  std::error_code none;
  if (is_simulator(source)) {
    SourceArgument argument;
    argument.text = source;
    if (auto good = check_source(argument); !good) return good.error();
    return std::vector<std::string>{source};
  }
  if (!fs::exists(source, none) && source.find_first_of("*?[") != std::string::npos) return matches(source);
  if (fs::is_directory(source, none)) {
    // Recordings are looked for some levels down: one of several would stand for the whole folder.
    Inside inside = look_inside(source);
    if (inside.folders >= 2 || (inside.good > 0 && !opens(source))) return std::move(inside.all);
  }
  return std::vector<std::string>{source};
}

}  // namespace

Result<std::vector<std::string>> find_sources(const std::vector<std::string>& sources) {
  std::vector<std::string> words;
  for (const std::string& source : sources) {
    if (!source.starts_with('@')) {
      words.push_back(source);
      continue;
    }
    const auto lines = lines_of_file(source.substr(1));
    if (!lines) return lines.error();
    words.insert(words.end(), lines->begin(), lines->end());
  }
  std::vector<std::string> out;
  std::set<std::string> seen;
  for (const std::string& word : words) {
    const auto found = expand(word);
    if (!found) return found.error();
    for (const std::string& path : *found) {
      std::string source = is_simulator(path) ? path : absolute(path);
      if (seen.insert(source).second) out.push_back(std::move(source));
    }
  }
  if (out.empty()) return Error{"no recording", "cliquevo fleet", "name folders, files, globs or sim:..."};
  return out;
}

std::vector<std::string> short_names(const std::vector<std::string>& sources) {
  // As many of a path's last parts as it takes; a simulator's text is as short as it gets.
  const auto ending = [](const std::string& source, int parts) {
    if (is_simulator(source)) return source;
    std::size_t at = source.size();
    for (int k = 0; k < parts && at != std::string::npos && at > 0; ++k) at = source.rfind('/', at - 1);
    return at == std::string::npos ? source : source.substr(at + 1);
  };
  constexpr int kMostParts = 32;
  std::vector<std::string> out(sources.size());
  std::vector<int> parts(sources.size(), 1);
  for (bool again = true; again;) {
    again = false;
    std::map<std::string, int> count;
    for (std::size_t i = 0; i < sources.size(); ++i) ++count[out[i] = ending(sources[i], parts[i])];
    for (std::size_t i = 0; i < sources.size(); ++i) {
      if (count[out[i]] < 2 || parts[i] >= kMostParts) continue;
      ++parts[i];
      again = true;
    }
  }
  return out;
}

}  // namespace cliquevo::tools::fleet
