// SPDX-License-Identifier: BSD-3-Clause
// From the file's text to a configuration.
#include <algorithm>
#include <filesystem>
#include <map>
#include <numeric>
#include <set>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include "core/base/printable.h"
#include "daemon/pipeline/config.h"
#include "daemon/pipeline/config_text.h"
#include "daemon/pipeline/keys/key_reader.h"
#include "daemon/pipeline/keys/keys.h"

namespace cliquevo::daemon {

namespace {

namespace fs = std::filesystem;

// A key as it stands in the file.
struct Entry {
  YAML::Node value;
  int line = 0;
};

std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      row[j] = std::min({above + 1, row[j - 1] + 1, diagonal + (a[i - 1] == b[j - 1] ? 0 : 1)});
      diagonal = above;
    }
  }
  return row[b.size()];
}

// The known keys: which are sections, and what each section holds.
struct Known {
  std::set<std::string> keys;
  std::map<std::string, std::set<std::string>> sections;  // "" is the whole file

  explicit Known(const KeyTable& table) {
    for (const Key& key : table.keys()) {
      const std::string& path = key.name;
      keys.insert(path);
      std::string section;
      for (std::size_t from = 0, dot = 0; dot != std::string::npos; from = dot + 1) {
        dot = path.find('.', from);
        sections[section].insert(path.substr(from, dot - from));
        section = path.substr(0, dot);
      }
    }
  }

  std::string suggestion(const std::string& section, const std::string& name) const {
    const std::set<std::string>& siblings = sections.at(section);
    const auto nearest = std::min_element(siblings.begin(), siblings.end(), [&](const auto& a, const auto& b) {
      return edit_distance(name, a) < edit_distance(name, b);
    });
    if (edit_distance(name, *nearest) <= std::max<std::size_t>(2, name.size() / 3)) {
      return fmt::format("did you mean '{}'?", *nearest);
    }
    return fmt::format("known {} are {}", section.empty() ? "sections" : "keys", fmt::join(siblings, ", "));
  }
};

// Bounds in pixels and grey levels, which only suited some cameras.
bool retired(const std::string& key) {
  return key == "odometry.refine_max_residual" || key == "odometry.max_reprojection_error_px" ||
         key == "odometry.max_unsteadiness_px";
}

Result<void> collect(const YAML::Node& map, const std::string& section, const Known& known, const std::string& path,
                     std::map<std::string, Entry>& entries) {
  std::set<std::string> seen;
  for (const auto& item : map) {
    const std::string where = fmt::format("{}:{}", path, item.first.Mark().line + 1);
    if (!item.first.IsScalar()) return Error{"not a key", where, "give `name: value`"};
    const std::string& name = item.first.Scalar();
    const std::string full = section.empty() ? name : fmt::format("{}.{}", section, name);
    if (!seen.insert(name).second) return Error{fmt::format("key '{}' twice", full), where, "keep one of them"};
    if (known.keys.contains(full)) {
      entries[full] = {item.second, item.first.Mark().line + 1};
    } else if (!known.sections.contains(full)) {
      if (retired(full)) {
        return Error{fmt::format("'{}' is no longer a key", full), where,
                     "remove it: bounds follow the camera's measured noise now"};
      }
      return Error{fmt::format("unknown key '{}'", full), where, known.suggestion(section, name)};
    } else if (item.second.IsMap()) {
      if (auto inner = collect(item.second, full, known, path, entries); !inner) return inner;
    } else if (!item.second.IsNull()) {
      return Error{fmt::format("'{}' is a section", full), where,
                   fmt::format("give its keys on lines of their own: {}", fmt::join(known.sections.at(full), ", "))};
    }
  }
  return {};
}

// Names the line of the key that a check found at fault.
Error with_line(const Error& error, const std::string& path, const std::map<std::string, Entry>& entries) {
  const std::string name = error.where.substr(0, error.where.find_first_of(" =:"));
  std::string where = path;
  if (const auto found = entries.find(name); found != entries.end()) {
    where = fmt::format("{}:{}", path, found->second.line);
  }
  return {fmt::format("{} ({})", error.what, error.where), where, error.remedy};
}

// Sets the file's values, key by key.
Result<void> read_entries(const KeyTable& table, const std::map<std::string, Entry>& entries, const std::string& path) {
  for (const Key& key : table.keys()) {
    const auto entry = entries.find(key.name);
    if (entry == entries.end()) continue;
    const std::string fallback = key.value();
    if (read_value(key, entry->second.value, fs::path(path).parent_path().string())) continue;
    return Error{fmt::format("wrong value for '{}'", key.name), fmt::format("{}:{}", path, entry->second.line),
                 fmt::format("give {}; the default is {}", key.expects(), fallback.empty() ? "empty" : fallback)};
  }
  return {};
}

Result<Config> parse(const std::string& text, const std::string& path) {
  if (auto ok = check_config_text(text, path); !ok) return ok.error();
  YAML::Node root;
  try {
    root = YAML::Load(text);
  } catch (const std::exception& error) {
    return Error{"cannot read configuration", path, fmt::format("{}; correct the YAML", error.what())};
  }
  if (!root.IsMap() && !root.IsNull()) {
    return Error{"cannot read configuration", path, "give sections with `key: value` lines, as config/cliquevo.yaml"};
  }
  Config config = default_config();
  const KeyTable table = config_keys(config);
  std::map<std::string, Entry> entries;
  if (auto collected = collect(root, "", Known(table), path, entries); !collected) return collected.error();
  if (auto ok = read_entries(table, entries, path); !ok) return ok.error();
  config.T_body_camera = config.body.T_body_camera();
  if (auto ok = config.check(); !ok) return with_line(ok.error(), path, entries);
  return config;
}

}  // namespace

Result<Config> read_config(const std::string& path) {
  const auto text = read_config_text(path);
  if (!text) return text.error();
  return parse_config(*text, path);
}

Result<Config> parse_config(const std::string& text, const std::string& path) {
  auto config = parse(text, path);
  return config ? std::move(config) : Result<Config>(printable(config.error()));  // which names what stands in the file
}

}  // namespace cliquevo::daemon
