// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/log_names.h"

#include <algorithm>
#include <charconv>
#include <ctime>
#include <filesystem>
#include <sys/stat.h>
#include <system_error>
#include <tuple>
#include <utility>

#include <fmt/format.h>

#include "drivers/recorder.h"

namespace cliquevo::daemon {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kPrefix = "cliquevo-";
constexpr std::string_view kSuffix = ".lcm";

// Takes `count` digits off the front.
std::optional<int> digits(std::string_view& text, std::size_t count) {
  int value = 0;
  if (text.size() < count || text.substr(0, count).find_first_not_of("0123456789") != std::string_view::npos) {
    return std::nullopt;
  }
  if (std::from_chars(text.data(), text.data() + count, value).ec != std::errc{}) return std::nullopt;
  text.remove_prefix(count);
  return value;
}

bool take(std::string_view& text, std::string_view front) {
  if (!text.starts_with(front)) return false;
  text.remove_prefix(front.size());
  return true;
}

std::optional<std::int64_t> time_of(std::string_view& text) {
  const auto year = digits(text, 4);
  const auto month = digits(text, 2);
  const auto day = digits(text, 2);
  if (!take(text, "T")) return std::nullopt;
  const auto hour = digits(text, 2);
  const auto minute = digits(text, 2);
  const auto second = digits(text, 2);
  if (!year || !month || !day || !hour || !minute || !second || !take(text, "Z")) return std::nullopt;
  std::tm parts{};
  parts.tm_year = *year - 1900;
  parts.tm_mon = *month - 1;
  parts.tm_mday = *day;
  parts.tm_hour = *hour;
  parts.tm_min = *minute;
  parts.tm_sec = *second;
  return ::timegm(&parts);
}

// A number of three digits or more.
std::optional<int> number(std::string_view& text) {
  const std::size_t count = std::min(text.find_first_not_of("0123456789"), text.size());
  return count >= 3 && count <= 9 ? digits(text, count) : std::nullopt;
}

// What the folder holds by such names.
std::vector<std::pair<std::string, LogName>> named_logs(const std::string& folder) {
  std::vector<std::pair<std::string, LogName>> out;
  std::error_code ec;
  for (fs::directory_iterator entry(folder, ec); !ec && entry != fs::directory_iterator(); entry.increment(ec)) {
    if (const auto name = parse_log_name(entry->path().filename().string())) {
      out.emplace_back(entry->path().string(), *name);
    }
  }
  return out;
}

}  // namespace

std::optional<LogName> parse_log_name(std::string_view text) {
  LogName name;
  if (!take(text, kPrefix)) return std::nullopt;
  const auto start_s = time_of(text);
  if (!start_s) return std::nullopt;
  name.start_s = *start_s;
  if (take(text, ".")) {
    const auto run = number(text);
    if (!run) return std::nullopt;
    name.run = *run;
  }
  if (!take(text, "-")) return std::nullopt;
  const auto part = number(text);
  if (!part || text != kSuffix) return std::nullopt;
  name.part = *part;
  return name;
}

std::string log_name(std::int64_t start_s, int run) {
  const std::time_t time = start_s;
  std::tm parts{};
  ::gmtime_r(&time, &parts);
  const std::string when = fmt::format("{:04}{:02}{:02}T{:02}{:02}{:02}Z", parts.tm_year + 1900, parts.tm_mon + 1,
                                       parts.tm_mday, parts.tm_hour, parts.tm_min, parts.tm_sec);
  return fmt::format("{}{}{}{}", kPrefix, when, run > 1 ? fmt::format(".{:03}", run) : "", kSuffix);
}

std::vector<std::string> own_logs(const std::string& folder) {
  using Age = std::tuple<std::int64_t, std::int64_t, int, int>;
  std::vector<std::pair<Age, std::string>> found;
  for (const auto& [path, name] : named_logs(folder)) {
    struct stat status = {};
    if (::lstat(path.c_str(), &status) != 0 || !drivers::is_own_log(path)) continue;
    const std::int64_t age_s = std::min<std::int64_t>(name.start_s, status.st_mtime);
    found.emplace_back(Age{age_s, name.start_s, name.run, name.part}, path);
  }
  std::sort(found.begin(), found.end());
  std::vector<std::string> out;
  out.reserve(found.size());
  for (auto& [age, path] : found) out.push_back(std::move(path));
  return out;
}

int next_run(const std::string& folder, std::int64_t start_s) {
  int run = 1;
  for (const auto& [path, name] : named_logs(folder)) {
    if (name.start_s == start_s) run = std::max(run, name.run + 1);
  }
  return run;
}

}  // namespace cliquevo::daemon
