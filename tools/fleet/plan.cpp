// SPDX-License-Identifier: BSD-3-Clause
#include "tools/fleet/plan.h"

#include <algorithm>
#include <charconv>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "drivers/own_folder.h"
#include "tools/fleet/digest.h"

namespace cliquevo::tools::fleet {

using nlohmann::json;

namespace {

constexpr int kVersion = 1;  // of the file's form
constexpr std::size_t kMostBytes = std::size_t{2} << 30U;

std::optional<std::size_t> number(std::string_view text) {
  std::size_t out = 0;
  const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), out);
  if (failed != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return out;
}

}  // namespace

std::string Plan::unit_name(const Unit& unit) const {
  return fmt::format("{} with {}", recording_of(unit).name, configuration_of(unit).name);
}

std::string plan_file_of(const std::string& text) { return fmt::format("plan-{}.json", sha256(text).substr(0, 12)); }

std::string plan_text(const Plan& plan) {
  json out = {{"cliquevo_fleet_plan", kVersion},
              {"version", plan.version},
              {"build", plan.build},
              {"program", plan.program},
              {"cache", plan.cache},
              {"trajectories", plan.trajectories},
              {"recordings", json::array()},
              {"configurations", json::array()},
              {"units", json::array()}};
  for (const Recording& r : plan.recordings) {
    json row = {{"name", r.name}, {"source", r.source}, {"frames", r.frames}, {"bytes", r.bytes}};
    if (!r.problem.empty()) row["problem"] = r.problem;
    out["recordings"].push_back(std::move(row));
  }
  for (const Configuration& c : plan.configurations)
    out["configurations"].push_back({{"name", c.name}, {"yaml", c.yaml}});
  for (const Unit& u : plan.units) out["units"].push_back({u.key, u.recording, u.configuration});
  return out.dump(1, ' ', false, json::error_handler_t::replace) + "\n";
}

Result<Plan> parse_plan(const std::string& text, const std::string& where) {
  const Error none{"no plan of a fleet", where, "make one with cliquevo fleet plan of this version"};
  try {
    const json in = json::parse(text);
    if (in.at("cliquevo_fleet_plan") != kVersion) return none;
    Plan out;
    out.version = in.at("version");
    out.build = in.at("build");
    out.program = in.at("program");
    out.cache = in.at("cache");
    out.trajectories = in.at("trajectories");
    for (const json& r : in.at("recordings")) {
      out.recordings.push_back(
          {r.at("name"), r.at("source"), r.at("frames"), r.at("bytes"), r.value("problem", std::string())});
    }
    for (const json& c : in.at("configurations")) out.configurations.push_back({c.at("name"), c.at("yaml")});
    for (const json& u : in.at("units")) {
      Unit unit{u.at(0), u.at(1), u.at(2)};
      const bool key = unit.key.size() == 64 && unit.key.find_first_not_of("0123456789abcdef") == std::string::npos;
      if (!key || unit.recording >= out.recordings.size() || unit.configuration >= out.configurations.size()) {
        return none;
      }
      out.units.push_back(std::move(unit));
    }
    return out;
  } catch (const json::exception&) {
    return none;
  }
}

Result<Plan> read_plan(const std::string& path) {
  const std::filesystem::path file(path);
  const std::string folder = file.has_parent_path() ? file.parent_path().string() : ".";
  std::error_code none;
  if (!std::filesystem::is_regular_file(file, none)) {
    return Error{"there is no plan", path, "make one: cliquevo fleet plan --out DIR SOURCES"};
  }
  const auto own = drivers::OwnFolder::open(folder);
  if (!own) return own.error();
  const auto text = own->read(file.filename().string(), kMostBytes);
  if (!text) return Error{"the plan is not one of yours", path, "it must be a file that you alone may write"};
  return parse_plan(*text, path);
}

Result<std::vector<std::size_t>> parse_units(const std::string& text, std::size_t count) {
  std::vector<std::size_t> out;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string_view part = std::string_view(text).substr(begin, end - begin);
    const std::size_t dash = part.find('-');
    const auto first = number(part.substr(0, dash));
    const auto last = dash == std::string_view::npos ? first : number(part.substr(dash + 1));
    if (!first || !last || *last < *first || *last >= count) {
      return Error{"no units of this plan", text, fmt::format("name numbers from 0 to {}: 0-9,12", count - 1)};
    }
    for (std::size_t k = *first; k <= *last; ++k) out.push_back(k);
    begin = end + 1;
  }
  return out;
}

std::string units_text(const std::vector<std::size_t>& units) {
  std::string out;
  for (std::size_t k = 0; k < units.size();) {
    std::size_t last = k;
    while (last + 1 < units.size() && units[last + 1] == units[last] + 1) ++last;
    if (!out.empty()) out += ',';
    out += last == k ? fmt::format("{}", units[k]) : fmt::format("{}-{}", units[k], units[last]);
    k = last + 1;
  }
  return out;
}

}  // namespace cliquevo::tools::fleet
