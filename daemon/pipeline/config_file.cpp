// SPDX-License-Identifier: BSD-3-Clause
// From files' texts and the command line's settings to a configuration.
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

// A key as it stands in a file or a setting.
struct Entry {
  YAML::Node value;
  std::string where;   // "rig.yaml:12"
  std::string folder;  // where relative paths start
};
using Entries = std::map<std::string, Entry>;

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
                     Entries& entries) {
  std::set<std::string> seen;
  for (const auto& item : map) {
    const std::string where = fmt::format("{}:{}", path, item.first.Mark().line + 1);
    if (!item.first.IsScalar()) return Error{"not a key", where, "give `name: value`"};
    const std::string& name = item.first.Scalar();
    const std::string full = section.empty() ? name : fmt::format("{}.{}", section, name);
    if (!seen.insert(name).second) return Error{fmt::format("key '{}' twice", full), where, "keep one of them"};
    if (known.keys.contains(full)) {
      entries[full] = {item.second, where, fs::path(path).parent_path().string()};
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

// Names the place of the key that a check found at fault.
Error with_place(const Error& error, const std::string& otherwise, const Entries& entries) {
  const std::string name = error.where.substr(0, error.where.find_first_of(" =:"));
  const auto found = entries.find(name);
  const std::string where = found != entries.end() ? found->second.where : otherwise;
  return {fmt::format("{} ({})", error.what, error.where), where, error.remedy};
}

// Sets the entries, key by key.
Result<void> read_entries(const KeyTable& table, const Entries& entries) {
  for (const Key& key : table.keys()) {
    const auto entry = entries.find(key.name);
    if (entry == entries.end()) continue;
    const std::string fallback = key.value();
    if (read_value(key, entry->second.value, entry->second.folder)) continue;
    return Error{fmt::format("wrong value for '{}'", key.name), entry->second.where,
                 fmt::format("give {}; the default is {}", key.expects(), fallback.empty() ? "empty" : fallback)};
  }
  return {};
}

Result<void> collect_file(const std::string& text, const std::string& path, const Known& known, Entries& entries) {
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
  return collect(root, "", known, path, entries);
}

// A value of the command line, as a file would have it. What is neither a value nor a list is text.
YAML::Node setting_value(const std::string& text, const std::string& where) {
  if (!check_config_text(text, where)) return YAML::Node(text);
  const YAML::Node read = YAML::Load(text);
  return read.IsScalar() || read.IsSequence() ? read : YAML::Node(text);
}

Result<void> collect_setting(const std::string& setting, const Known& known, Entries& entries) {
  const std::string where = "--set " + setting;
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos || equals == 0) {
    return Error{"not a setting", where, "give section.key=value, e.g. stereo.workers=1"};
  }
  const std::string name = setting.substr(0, equals);
  if (known.keys.contains(name)) {
    entries[name] = {setting_value(setting.substr(equals + 1), where), where, ""};
    return {};
  }
  std::string section = name.substr(0, name.rfind('.') == std::string::npos ? 0 : name.rfind('.'));
  while (!known.sections.contains(section)) {
    section = section.substr(0, section.rfind('.') == std::string::npos ? 0 : section.rfind('.'));
  }
  const std::string rest = section.empty() ? name : name.substr(section.size() + 1);
  return Error{fmt::format("unknown key '{}'", name), where, known.suggestion(section, rest.substr(0, rest.find('.')))};
}

struct FileText {
  std::string path;
  std::string text;
};

Result<Config> parse(const std::vector<FileText>& files, const std::vector<std::string>& settings,
                     bool needs_calibration = true) {
  Config config = default_config();
  config.source.cameras.needs_calibration = needs_calibration;
  const KeyTable table = config_keys(config);
  const Known known(table);
  Entries entries;
  for (const FileText& file : files) {
    if (auto ok = collect_file(file.text, file.path, known, entries); !ok) return ok.error();
  }
  for (const std::string& setting : settings) {
    if (setting.size() > kLargestConfig) return Error{"setting too long", "--set", "give section.key=value"};
    if (auto ok = collect_setting(setting, known, entries); !ok) return ok.error();
  }
  if (auto ok = read_entries(table, entries); !ok) return ok.error();
  config.T_body_camera = config.body.T_body_camera();
  const std::string otherwise = files.empty() ? "--set" : files.back().path;
  if (auto ok = config.check(); !ok) return with_place(ok.error(), otherwise, entries);
  return config;
}

// Errors name what stands in files, which may be anything.
Result<Config> made_printable(Result<Config> config) {
  return config ? std::move(config) : Result<Config>(printable(config.error()));
}

}  // namespace

Result<Config> read_config(const ConfigSources& sources) {
  std::vector<FileText> files;
  for (const std::string& path : sources.files) {
    auto text = read_config_text(path);
    if (!text) return text.error();
    files.push_back({path, std::move(*text)});
  }
  return made_printable(parse(files, sources.settings, sources.needs_calibration));
}

Result<Config> read_config(const std::string& path) { return read_config(ConfigSources{{path}, {}}); }

Result<Config> parse_config(const std::string& text, const std::string& path) {
  return made_printable(parse({{path, text}}, {}));
}

}  // namespace cliquevo::daemon
