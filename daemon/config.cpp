// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/config.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <numeric>
#include <optional>
#include <set>
#include <type_traits>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include "core/base/printable.h"
#include "core/rt/handover.h"
#include "daemon/config_keys.h"
#include "daemon/config_text.h"

namespace cliquevo::daemon {

namespace {

namespace fs = std::filesystem;

constexpr const char* kAutomatic = "auto";  // how the file leaves an optional value open

// ---- values as text -------------------------------------------------------------------------------------------------

std::string to_text(bool value) { return value ? "true" : "false"; }
std::string to_text(double value) { return fmt::format("{}", value); }
std::string to_text(const std::string& value) { return value; }
std::string to_text(const std::optional<double>& value) { return value ? to_text(*value) : kAutomatic; }
std::string to_text(const Eigen::Vector3d& v) { return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z()); }
std::string to_text(const double (&v)[3]) { return fmt::format("[{}, {}, {}]", v[0], v[1], v[2]); }
template <typename T>
requires(std::is_integral_v<T> && !std::is_same_v<T, bool>) std::string to_text(T value) {
  return std::to_string(value);
}

template <typename T>
std::optional<T> parse_number(const std::string& text) {
  T value{};
  const char* begin = text.data() + (text.size() > 1 && text[0] == '+' && text[1] != '-' ? 1 : 0);
  const auto [end, failed] = std::from_chars(begin, text.data() + text.size(), value);
  if (failed != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  if constexpr (std::is_floating_point_v<T>) {
    if (!std::isfinite(value)) return std::nullopt;
  }
  return value;
}

// Each returns what was expected, or nothing when the node was that and is now in `value`.
using Expected = std::optional<std::string>;

Expected from_yaml(const YAML::Node& node, bool& value) {
  if (node.IsScalar() && (node.Scalar() == "true" || node.Scalar() == "false")) {
    value = node.Scalar() == "true";
    return std::nullopt;
  }
  return "true or false";
}

Expected from_yaml(const YAML::Node& node, double& value) {
  const auto number = node.IsScalar() ? parse_number<double>(node.Scalar()) : std::nullopt;
  if (!number) return "a number";
  value = *number;
  return std::nullopt;
}

template <typename T>
requires(std::is_integral_v<T> && !std::is_same_v<T, bool>) Expected from_yaml(const YAML::Node& node, T& value) {
  const auto number = node.IsScalar() ? parse_number<T>(node.Scalar()) : std::nullopt;
  if (!number) return std::is_signed_v<T> ? "a whole number" : "a whole number, not negative";
  value = *number;
  return std::nullopt;
}

Expected from_yaml(const YAML::Node& node, std::string& value) {
  if (!node.IsScalar() && !node.IsNull()) return "a text";
  value = node.IsNull() ? "" : node.Scalar();
  return std::nullopt;
}

Expected from_yaml(const YAML::Node& node, std::optional<double>& value) {
  if (node.IsScalar() && node.Scalar() == kAutomatic) {
    value.reset();
    return std::nullopt;
  }
  double number = 0.0;
  if (from_yaml(node, number)) return fmt::format("a number or {}", kAutomatic);
  value = number;
  return std::nullopt;
}

template <typename Three>
Expected three_from_yaml(const YAML::Node& node, Three& value) {
  constexpr const char* kExpected = "three numbers, [a, b, c]";
  if (!node.IsSequence() || node.size() != 3) return kExpected;
  for (std::size_t i = 0; i < 3; ++i) {
    if (from_yaml(node[i], value[i])) return kExpected;
  }
  return std::nullopt;
}
Expected from_yaml(const YAML::Node& node, Eigen::Vector3d& value) { return three_from_yaml(node, value); }
Expected from_yaml(const YAML::Node& node, double (&value)[3]) { return three_from_yaml(node, value); }

// What a visitor gets for a choice: names and the values they stand for.
template <typename T>
using Choices = std::initializer_list<std::pair<const char*, std::type_identity_t<T>>>;

// ---- the visitors ---------------------------------------------------------------------------------------------------

struct Lister {
  std::vector<std::pair<std::string, std::string>> out;
  template <typename T>
  void key(const char* path, const T& value) {
    out.emplace_back(path, to_text(value));
  }
  void file(const char* path, const std::string& value) { key(path, value); }
  template <typename T>
  void choice(const char* path, const T& value, Choices<T> choices) {
    for (const auto& [name, meant] : choices) {
      if (meant == value) out.emplace_back(path, name);
    }
  }
};

// A key as it stands in the file.
struct Entry {
  YAML::Node value;
  int line = 0;
};

struct Reader {
  const std::map<std::string, Entry>& entries;
  const std::string& path;
  std::optional<Error> error;

  template <typename T>
  void key(const char* name, T& value) {
    const Entry* entry = find(name);
    if (entry == nullptr) return;
    const std::string fallback = to_text(value);
    if (const Expected expected = from_yaml(entry->value, value)) refuse(name, *entry, *expected, fallback);
  }
  void file(const char* name, std::string& value) {
    if (find(name) == nullptr) return;
    key(name, value);
    if (!value.empty() && fs::path(value).is_relative()) {
      value = (fs::path(path).parent_path() / value).lexically_normal().string();
    }
  }
  template <typename T>
  void choice(const char* name, T& value, Choices<T> choices) {
    const Entry* entry = find(name);
    if (entry == nullptr) return;
    std::vector<std::string> names;
    std::string fallback;
    for (const auto& [text, meant] : choices) {
      if (entry->value.IsScalar() && entry->value.Scalar() == text) {
        value = meant;
        return;
      }
      if (meant == value) fallback = text;
      names.emplace_back(text);
    }
    refuse(name, *entry, fmt::format("one of {}", fmt::join(names, ", ")), fallback);
  }

 private:
  const Entry* find(const char* name) const {
    if (error) return nullptr;
    const auto found = entries.find(name);
    return found == entries.end() ? nullptr : &found->second;
  }
  void refuse(const char* name, const Entry& entry, const std::string& expected, const std::string& fallback) {
    error = Error{fmt::format("wrong value for '{}'", name), fmt::format("{}:{}", path, entry.line),
                  fmt::format("give {}; the default is {}", expected, fallback.empty() ? "empty" : fallback)};
  }
};

// ---- from the file to entries ---------------------------------------------------------------------------------------

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

  explicit Known(const Config& config) {
    for (const auto& [path, value] : list_config(config)) {
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

// A room's parameters name their fields; in the file they stand in a section.
Result<void> in_section(const char* section, const Result<void>& checked) {
  if (checked) return {};
  const Error& error = checked.error();
  return Error{error.what, fmt::format("{}.{}", section, error.where), error.remedy};
}

Error own_range(const char* key, const char* remedy) { return {"configuration value out of range", key, remedy}; }

}  // namespace

RigidTransform Mounting::T_body_camera() const {
  constexpr double kRadian = std::numbers::pi / 180.0;
  RigidTransform T;
  Eigen::Matrix3d R_forward;  // camera axes of a camera that looks forward: X right, Y down, Z forward
  R_forward << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  T.R = (Eigen::AngleAxisd(kRadian * roll_pitch_yaw_deg.z(), Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(kRadian * roll_pitch_yaw_deg.y(), Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(kRadian * roll_pitch_yaw_deg.x(), Eigen::Vector3d::UnitX()))
            .toRotationMatrix() *
        R_forward;
  T.t = translation_m;
  return T;
}

Config default_config() {
  Config config;
  config.stereo.workers = 2;  // the library takes one thread unless told otherwise; a vehicle wants the pose soon
  config.T_body_camera = config.body.T_body_camera();
  return config;
}

Result<void> Config::check() const {
  if (!(source.speed >= 0.0)) return own_range("source.speed", "give 0 (as fast as possible) or more");
  const auto& played = source.recording;
  if (played.rate_hz && !(*played.rate_hz > 0.0)) return own_range("source.recording.rate_hz", "give more than 0");
  if (played.first < 0) return own_range("source.recording.first", "give 0 or more");
  if (played.every < 1) return own_range("source.recording.every", "give 1 or more");
  if (played.last < -1 || (played.last >= 0 && played.last < played.first)) {
    return own_range("source.recording.last", "give -1 (the last there is), or a pair not before the first");
  }
  if (played.pair_tolerance_s && !(*played.pair_tolerance_s >= 0.0)) {
    return own_range("source.recording.pair_tolerance_s", "give 0 or more");
  }
  if (source.type == "recording" && played.path.empty()) {
    return own_range("source.recording.path", "name the recording's folder");
  }
  for (const auto& [key, channel] :
       {std::pair{"lcm.delta_channel", &lcm.delta_channel}, std::pair{"lcm.pose_channel", &lcm.pose_channel},
        std::pair{"lcm.status_channel", &lcm.status_channel}}) {
    if (channel->empty() || channel->size() > 63) return own_range(key, "give a name of 1 to 63 characters");
  }
  for (const auto& [key, channel] :
       {std::pair{"lcm.delta_body_channel", &lcm.delta_body_channel},
        std::pair{"lcm.images_channel", &lcm.images_channel}, std::pair{"lcm.movers_channel", &lcm.movers_channel},
        std::pair{"lcm.features_channel", &lcm.features_channel}, std::pair{"lcm.health_channel", &lcm.health_channel},
        std::pair{"lcm.command_channel", &lcm.command_channel}}) {
    if (channel->size() > 63) return own_range(key, "give a name of 63 characters at most, or none");
  }
  if (!(lcm.images_rate_hz >= 0.01 && lcm.images_rate_hz <= 1000.0)) {
    return own_range("lcm.images_rate_hz", "give 0.01 to 1000");
  }
  for (const auto& [key, cpu] : {std::pair{"realtime.stereo_cpu", realtime.stereo_cpu},
                                 std::pair{"realtime.odometry_cpu", realtime.odometry_cpu},
                                 std::pair{"realtime.worker_cpu", realtime.worker_cpu}}) {
    if (cpu < -1 || cpu > 1023) return own_range(key, "give -1 (any core), or a core from 0 to 1023");
  }
  for (const auto& [key, priority] : {std::pair{"realtime.stereo_priority", realtime.stereo_priority},
                                      std::pair{"realtime.odometry_priority", realtime.odometry_priority},
                                      std::pair{"realtime.output_priority", realtime.output_priority}}) {
    if (priority < 0 || priority > 99) return own_range(key, "give 0 (ordinary), or 1 to 99");
  }
  if (realtime.catch_up_frames < 0 || realtime.catch_up_frames > rt::Handover::kMostBacklog) {
    static_assert(rt::Handover::kMostBacklog == 31);
    return own_range("realtime.catch_up_frames", "give 0 to 31");
  }
  if (auto ok = in_section("source.recording", source.recording.calibration_options.check()); !ok) return ok;
  if (auto ok = in_section("source.cameras", source.cameras.check()); !ok) return ok;
  if (source.is_live()) {
    if (auto ok = in_section("source.cameras", source.cameras.check_names()); !ok) return ok;
  }
  const RecordingConfig& log = this->recording;
  if (log.at_start && log.folder.empty()) return own_range("recording.folder", "name a folder to record into");
  if (log.max_file_mb < 1 || log.max_file_mb > 1'000'000) {
    return own_range("recording.max_file_mb", "give 1 to 1000000");
  }
  if (log.max_total_mb < 2 || log.max_total_mb > 100'000'000) {
    return own_range("recording.max_total_mb", "give 2 to 100000000");
  }
  if (log.queue_mb < 1 || log.queue_mb > 4096) return own_range("recording.queue_mb", "give 1 to 4096");
  if (auto ok = in_section("rectify", rectify.check()); !ok) return ok;
  if (auto ok = in_section("stereo", stereo.check()); !ok) return ok;
  if (auto ok = in_section("odometry", odometry.check()); !ok) return ok;
  return in_section("source.simulator", source.simulator.check());
}

std::vector<std::pair<std::string, std::string>> list_config(const Config& config) {
  Lister lister;
  visit_config_keys(config, lister);
  return lister.out;
}

Result<Config> read_config(const std::string& path) {
  const auto text = read_config_text(path);
  if (!text) return text.error();
  return parse_config(*text, path);
}

namespace {

Result<Config> parse(const std::string& text, const std::string& path) {
  if (auto ok = check_config_text(text, path); !ok) return ok.error();
  YAML::Node root;
  try {
    root = YAML::Load(text);
  } catch (const std::exception& error) {
    return Error{"cannot read configuration", path, fmt::format("{}; mend the YAML", error.what())};
  }
  if (!root.IsMap() && !root.IsNull()) {
    return Error{"cannot read configuration", path, "give sections with `key: value` lines, as config/cliquevo.yaml"};
  }
  Config config = default_config();
  std::map<std::string, Entry> entries;
  if (auto collected = collect(root, "", Known(config), path, entries); !collected) return collected.error();
  Reader reader{entries, path, std::nullopt};
  visit_config_keys(config, reader);
  if (reader.error) return *reader.error;
  config.T_body_camera = config.body.T_body_camera();
  if (auto ok = config.check(); !ok) return with_line(ok.error(), path, entries);
  return config;
}

}  // namespace

Result<Config> parse_config(const std::string& text, const std::string& path) {
  auto config = parse(text, path);
  return config ? std::move(config) : Result<Config>(printable(config.error()));  // which names what stands in the file
}

}  // namespace cliquevo::daemon
