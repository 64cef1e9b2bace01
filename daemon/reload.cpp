// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/reload.h"

#include <string_view>

#include <spdlog/spdlog.h>

#include "daemon/log.h"
#include "daemon/pipeline/keys/keys.h"

namespace cliquevo::daemon {

namespace {

// What makes a reloadable key take effect, by the beginning of its name.
struct Effect {
  std::string_view keys;
  void (*apply)(const Config&, Output&, Recording&);
  const char* when;
};
constexpr Effect kEffects[] = {
    {"log.level", [](const Config& config, Output&, Recording&) { set_up_log(config.log_level); }, ""},
    {"lcm.images_rate_hz",
     [](const Config& config, Output& output, Recording&) { output.tap.set_rate(config.lcm.images_rate_hz); }, ""},
    {"lcm.points_rate_hz",
     [](const Config& config, Output& output, Recording&) {
       if (output.points) output.points->set_rate(config.lcm.points_rate_hz);
     },
     ""},
    {"recording.", [](const Config& config, Output&, Recording& recording) { recording.configure(config.recording); },
     ", from the next recording on"},
};

void apply(const Key& key, const Config& config, Output& output, Recording& recording) {
  for (const Effect& effect : kEffects) {
    if (!key.name.starts_with(effect.keys)) continue;
    effect.apply(config, output, recording);
    spdlog::info("reloaded: {} is now {}{}", key.name, key.value(), effect.when);
  }
}

}  // namespace

void reload(const ConfigArgument& source, Config& in_force, Output& output, Recording& recording) {
  auto config = read_daemon_config(source);
  if (!config) return report(config.error());
  const KeyTable now = config_keys(in_force);
  const KeyTable next = config_keys(*config);
  for (std::size_t i = 0; i < now.keys().size(); ++i) {
    const Key& key = now.keys()[i];
    const Key& wanted = next.keys()[i];
    if (wanted.value() == key.value()) continue;
    if (!key.reloadable) {
      spdlog::warn("reloaded: {} = {} takes effect at the next start", wanted.name, wanted.value());
      continue;
    }
    key.copy_from(wanted);
    apply(key, in_force, output, recording);
  }
  spdlog::info("configuration read again");
}

}  // namespace cliquevo::daemon
