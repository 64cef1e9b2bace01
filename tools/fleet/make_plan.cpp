// SPDX-License-Identifier: BSD-3-Clause
#include "tools/fleet/make_plan.h"

#include <filesystem>
#include <map>
#include <optional>
#include <system_error>
#include <unistd.h>

#include <fmt/format.h>

#include "daemon/pipeline/effective_config.h"
#include "tools/fleet/unit_key.h"
#include "tools/source_argument.h"

namespace cliquevo::tools::fleet {

namespace fs = std::filesystem;

namespace {

// Paths in a plan are read in other folders.
void make_absolute(std::string& path) {
  std::error_code error;
  if (!path.empty()) path = fs::absolute(path, error).lexically_normal().string();
}

std::string stem(const std::string& file) { return file.empty() ? "default" : fs::path(file).stem().string(); }

// Files of one name in two folders, and the same value twice: a name must not mean two things.
void number_equal_names(std::vector<ReadConfiguration>& configurations) {
  std::map<std::string, int> seen;
  for (ReadConfiguration& c : configurations) {
    if (const int before = seen[c.name]++; before > 0) c.name += fmt::format(" ({})", before + 1);
  }
}

Result<SourceIdentity> open_and_identify(const std::string& source, const daemon::Config& config) {
  if (is_simulator(source)) return identify_simulated(source, config);
  const auto opened = open_unit_source(source, config);
  if (!opened) return opened.error();
  return identify(source, config, (*opened)->info());
}

// What a source is, by the way of reading it: a sweep over anything else opens no recording again.
class Identities {
 public:
  Result<SourceIdentity> of(const std::string& source, const ReadConfiguration& configuration) {
    const std::string way = source + "\n" + reading_text(configuration.config);
    auto found = known_.find(way);
    if (found == known_.end()) found = known_.emplace(way, open_and_identify(source, configuration.config)).first;
    return found->second;
  }

 private:
  std::map<std::string, Result<SourceIdentity>> known_;
};

}  // namespace

Result<std::vector<std::string>> sweep_values(const std::string& setting) {
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos || equals == 0) {
    return Error{"no setting", setting, "write --set section.key=value, or =value,value,... for a sweep"};
  }
  std::vector<std::string> out;
  std::string value;
  int depth = 0;
  char quote = 0;
  const auto finish = [&] {
    out.push_back(setting.substr(0, equals + 1) + value);
    value.clear();
  };
  for (const char c : setting.substr(equals + 1)) {
    if (quote != 0) {
      quote = c == quote ? '\0' : quote;
    } else if (c == '\'' || c == '"') {
      quote = c;
    } else if (c == '[' || c == '{') {
      ++depth;
    } else if (c == ']' || c == '}') {
      --depth;
    } else if (c == ',' && depth == 0) {
      finish();
      continue;
    }
    value += c;
  }
  finish();
  return out;
}

Result<std::vector<ReadConfiguration>> read_configurations(const PlanArgument& argument) {
  struct Combination {
    std::vector<std::string> settings;
    std::string name;
  };
  std::vector<Combination> combinations{{}};
  for (const std::string& setting : argument.settings) {
    const auto values = sweep_values(setting);
    if (!values) return values.error();
    std::vector<Combination> longer;
    for (const Combination& before : combinations) {
      for (const std::string& value : *values) {
        Combination next = before;
        next.settings.push_back(value);
        if (values->size() > 1) next.name += " " + value;
        longer.push_back(std::move(next));
      }
    }
    combinations = std::move(longer);
  }
  std::vector<std::string> files = argument.configs;
  if (files.empty()) files.emplace_back();
  std::vector<ReadConfiguration> out;
  for (const std::string& file : files) {
    for (const Combination& combination : combinations) {
      daemon::ConfigSources sources{{}, combination.settings};
      if (!file.empty()) sources.files.push_back(file);
      auto config = daemon::read_config(sources);
      if (!config) return config.error();
      config->stereo.workers = 1;  // as many units at once as processors; no result depends on it
      for (std::string* path : {&config->source.recording.calibration, &config->source.recording.left_mask,
                                &config->source.recording.right_mask}) {
        make_absolute(*path);
      }
      out.push_back({stem(file) + combination.name, std::move(*config)});
    }
  }
  number_equal_names(out);
  return out;
}

Result<std::string> unit_program(const std::string& asked) {
  std::error_code error;
  const fs::path self = fs::read_symlink("/proc/self/exe", error);
  const fs::path folder = self.parent_path();
  std::vector<fs::path> places{folder / "cliquevo", folder / "../../bin/cliquevo"};
  if (!asked.empty()) places = {fs::absolute(asked, error)};
  for (const fs::path& place : places) {
    if (::access(place.c_str(), X_OK) == 0 && fs::is_regular_file(place, error))
      return place.lexically_normal().string();
  }
  return Error{"no program to compute units with", places.front().lexically_normal().string(),
               "install the package cliquevo, or name its program: --program FILE"};
}

Result<Plan> make_plan(const PlanArgument& argument, const std::string& build) {
  const auto configurations = read_configurations(argument);
  if (!configurations) return configurations.error();
  const auto sources = find_sources(argument.sources);
  if (!sources) return sources.error();
  const std::vector<std::string> names = short_names(*sources);
  Plan out;
  out.build = build;
  out.version = CLIQUEVO_VERSION;
  out.trajectories = argument.trajectories;
  for (const ReadConfiguration& c : *configurations) {
    out.configurations.push_back({c.name, daemon::effective_config_yaml(c.config)});
  }
  Identities identities;
  for (std::size_t i = 0; i < sources->size(); ++i) {
    Recording recording{names[i], (*sources)[i], -1, 0, ""};
    for (std::size_t j = 0; j < configurations->size(); ++j) {
      const auto identity = identities.of(recording.source, (*configurations)[j]);
      if (!identity) {
        if (recording.problem.empty()) recording.problem = identity.error().line();
        continue;
      }
      recording.frames = identity->frames;
      recording.bytes = identity->bytes;
      out.units.push_back({unit_key(build, (*configurations)[j].config, *identity, out.trajectories), i, j});
    }
    out.recordings.push_back(std::move(recording));
  }
  if (!out.units.empty()) return out;
  return Error{"no recording can be opened", fmt::format("{} sources", sources->size()),
               "see the first: " + out.recordings.front().problem};
}

}  // namespace cliquevo::tools::fleet
