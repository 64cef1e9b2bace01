// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/pose_names.h"

#include <algorithm>
#include <array>
#include <utility>

namespace cliquevo::daemon {

namespace {

constexpr bool is_lower(char c) { return c >= 'a' && c <= 'z'; }
constexpr bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }
constexpr bool is_digit(char c) { return c >= '0' && c <= '9'; }
constexpr char lower(char c) { return is_upper(c) ? static_cast<char>(c - 'A' + 'a') : c; }

template <std::size_t count>
bool is_one_of(std::string_view word, const std::array<std::string_view, count>& words) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

// Lower case; parted where a capital follows a small letter, and at whatever is no letter or digit.
std::vector<std::string> parts_of(std::string_view name) {
  std::vector<std::string> parts;
  char last = 0;
  for (const char c : name) {
    const bool word = is_lower(c) || is_upper(c) || is_digit(c);
    const bool begins = !is_lower(last) && !is_upper(last) && !is_digit(last);
    if (word && (begins || (is_lower(last) && is_upper(c)))) parts.emplace_back();
    if (word) parts.back() += lower(c);
    last = c;
  }
  return parts;
}

// "ns" of "time_ns".
void take_unit(ColumnName& name) {
  constexpr std::array<std::string_view, 14> kUnits{"s", "ms", "us", "ns",  "sec",    "secs",    "nsec",
                                                    "m", "mm", "cm", "deg", "degree", "degrees", "rad"};
  if (name.parts.size() < 2 || !is_one_of(name.parts.back(), kUnits)) return;
  if (name.unit.empty()) name.unit = name.parts.back();
  name.parts.pop_back();
}

bool is_other_quantity(const std::vector<std::string>& parts) {
  constexpr std::array<std::string_view, 12> kBegins{"vel",   "acc",   "ang", "gyr",  "bias", "cov",
                                                     "sigma", "twist", "lin", "grav", "std",  "err"};
  // Where they stand first: behind, they name frames ("p_W_B_x").
  constexpr std::array<std::string_view, 9> kFirst{"v", "a", "b", "w", "g", "bg", "ba", "bw", "omega"};
  if (parts.size() > 1 && is_one_of(parts.front(), kFirst)) return true;
  for (const std::string& part : parts) {
    if (std::any_of(kBegins.begin(), kBegins.end(), [&](std::string_view b) { return part.rfind(b, 0) == 0; }))
      return true;
  }
  return false;
}

ColumnRole time_role(const ColumnName& name) {
  constexpr std::array<std::string_view, 10> kTimes{"t",          "ts",    "time",    "stamp",    "timestamp",
                                                    "timestamps", "utime", "gpstime", "unixtime", "rostime"};
  constexpr std::array<std::string_view, 3> kSeconds{"sec", "secs", "seconds"};
  constexpr std::array<std::string_view, 6> kParts{"nsec", "nsecs", "nanosec", "nanosecs", "nanoseconds", "nanosecond"};
  const auto has = [&](std::string_view word) {
    return std::find(name.parts.begin(), name.parts.end(), word) != name.parts.end();
  };
  const std::string& last = name.parts.back();
  if (is_one_of(last, kParts) || is_one_of(name.unit, kParts)) return ColumnRole::part;
  const bool time = is_one_of(last, kTimes) || is_one_of(last, kSeconds) || has("timestamp") || has("stamp");
  if (!time || (last == "t" && name.parts.size() > 1)) return ColumnRole::none;
  return has("source") || has("destination") || has("src") || has("dst") ? ColumnRole::other_time : ColumnRole::time;
}

ColumnRole axis_role(const ColumnName& name) {
  constexpr std::array<std::string_view, 7> kTurns{"q", "quat", "quaternion", "rot", "rotation", "ori", "orientation"};
  constexpr std::array<std::string_view, 10> kPlaces{"t",           "p",    "pos", "position", "trans",
                                                     "translation", "tvec", "loc", "location", "coord"};
  std::string_view last = name.parts.back();
  const auto is_turn = [&](std::string_view word) { return is_one_of(word, kTurns); };
  bool turn = std::any_of(name.parts.begin(), name.parts.end() - 1, is_turn);
  if (last.size() > 1) {
    const std::string_view stem = last.substr(0, last.size() - 1);
    if (!is_turn(stem) && !is_one_of(stem, kPlaces)) return ColumnRole::none;
    turn = turn || is_turn(stem);
    last = last.substr(last.size() - 1);
  }
  if (last == "w") return ColumnRole::qw;
  if (last == "x") return turn ? ColumnRole::qx : ColumnRole::x;
  if (last == "y") return turn ? ColumnRole::qy : ColumnRole::y;
  if (last == "z") return turn ? ColumnRole::qz : ColumnRole::z;
  return ColumnRole::none;
}

ColumnRole role_of(const ColumnName& name) {
  constexpr std::array<std::pair<std::string_view, ColumnRole>, 22> kWords{
      {{"roll", ColumnRole::roll},         {"pitch", ColumnRole::pitch},
       {"yaw", ColumnRole::yaw},           {"heading", ColumnRole::heading},
       {"northing", ColumnRole::north},    {"north", ColumnRole::north},
       {"easting", ColumnRole::east},      {"east", ColumnRole::east},
       {"down", ColumnRole::down},         {"up", ColumnRole::up},
       {"altitude", ColumnRole::up},       {"alt", ColumnRole::up},
       {"height", ColumnRole::up},         {"id", ColumnRole::frame},
       {"idx", ColumnRole::frame},         {"index", ColumnRole::frame},
       {"frame", ColumnRole::frame},       {"frameid", ColumnRole::frame},
       {"framenumber", ColumnRole::frame}, {"number", ColumnRole::frame},
       {"num", ColumnRole::frame},         {"no", ColumnRole::frame}}};
  const auto& parts = name.parts;
  if (parts.empty() || is_other_quantity(parts)) return ColumnRole::none;
  if (std::find(parts.begin(), parts.end(), "child") != parts.end()) return ColumnRole::child_frame;
  if (const ColumnRole time = time_role(name); time != ColumnRole::none) return time;
  for (const auto& [word, role] : kWords) {
    if (parts.back() == word) return role;
  }
  return axis_role(name);
}

}  // namespace

std::vector<ColumnName> column_names(std::string_view heading) {
  int depth = 0;
  char between = ' ';
  for (const char c : heading) {
    depth += (c == '[' || c == '(') ? 1 : (c == ']' || c == ')') ? -1 : 0;
    if (depth <= 0 && (c == ';' || (c == ',' && between == ' '))) between = c;
  }
  std::vector<ColumnName> names(1);
  depth = 0;
  for (const char c : heading) {
    const bool opens = c == '[' || c == '(';
    const bool closes = c == ']' || c == ')';
    const bool blank = c == ' ' || c == '\t' || c == '\r';
    depth = std::max(0, depth + (opens ? 1 : closes ? -1 : 0));
    if (depth == 0 && (c == between || (between == ' ' && blank))) {
      names.emplace_back();
    } else if (depth > 0 && !opens) {
      names.back().unit += lower(c);
    } else if (!opens && !closes && c != '"' && c != '\'') {
      names.back().text += c;
    }
  }
  const auto is_empty = [](const ColumnName& name) {
    return name.text.find_first_not_of(" \t\r") == std::string::npos;
  };
  std::vector<ColumnName> out;
  for (ColumnName& name : names) {
    const bool empty = is_empty(name);
    if (between == ' ' && empty) {
      if (!out.empty() && !name.unit.empty()) out.back().unit = name.unit;  // "timestamp [ns] tx [m]"
      continue;
    }
    out.push_back(std::move(name));
  }
  while (!out.empty() && is_empty(out.back())) out.pop_back();
  for (ColumnName& name : out) {
    name.parts = parts_of(name.text);
    take_unit(name);
    name.role = role_of(name);
  }
  return out;
}

}  // namespace cliquevo::daemon
