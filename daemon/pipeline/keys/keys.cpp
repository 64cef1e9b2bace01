// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/keys/keys.h"

namespace cliquevo::daemon {

KeyTable config_keys(Config& config) {
  KeyTable table;
  add_source_keys(config.source, table);
  add_simulator_keys(config.source.simulator, table);
  add_stereo_keys(config.rectify, config.stereo, table);
  add_odometry_keys(config.odometry, table);
  add_daemon_keys(config, table);
  return table;
}

}  // namespace cliquevo::daemon
