// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/effective_config.h"

#include <vector>

namespace cliquevo::daemon {

namespace {

std::vector<std::string> split(const std::string& path) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t dot = path.find('.'); dot != std::string::npos; dot = path.find('.', begin)) {
    parts.push_back(path.substr(begin, dot - begin));
    begin = dot + 1;
  }
  parts.push_back(path.substr(begin));
  return parts;
}

// Plain where YAML takes it as it stands, else in single quotes, where only they need care.
std::string scalar(const std::string& value) {
  const bool list = value.size() > 1 && value.front() == '[' && value.back() == ']';
  const std::string safe = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789._-+/";
  if (list || (!value.empty() && value.find_first_not_of(safe) == std::string::npos)) return value;
  std::string out = "'";
  for (const char c : value) out += c == '\'' ? std::string("''") : std::string(1, c);
  return out + "'";
}

}  // namespace

std::string effective_config_yaml(const Config& config) {
  std::string out;
  std::vector<std::string> open;  // the sections that the last line stood in
  for (const auto& [path, value] : list_config(config)) {
    const std::vector<std::string> parts = split(path);
    std::size_t same = 0;
    while (same + 1 < parts.size() && same < open.size() && parts[same] == open[same]) ++same;
    open.assign(parts.begin(), parts.end() - 1);
    for (std::size_t depth = same; depth + 1 < parts.size(); ++depth) {
      out += std::string(2 * depth, ' ') + parts[depth] + ":\n";
    }
    out += std::string(2 * (parts.size() - 1), ' ') + parts.back() + ": " + scalar(value) + "\n";
  }
  return out;
}

}  // namespace cliquevo::daemon
