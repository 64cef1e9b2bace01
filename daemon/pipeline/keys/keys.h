// SPDX-License-Identifier: BSD-3-Clause
// The keys of the configuration file, one row each, in the file's order: name, place of the value, unit, range,
// meaning. A new key is its field and its row; the sample file, the page on it, the schema and the completion are
// written from here (tools/generate).
#pragma once

#include "daemon/pipeline/config.h"
#include "daemon/pipeline/keys/key.h"

namespace cliquevo::daemon {

// The rows of one room each, added to the table.
void add_source_keys(SourceConfig& source, KeyTable& table);
void add_simulator_keys(drivers::SimulatorOptions& simulator, KeyTable& table);
void add_stereo_keys(stereo::RectifyParams& rectify, stereo::StereoParams& stereo, KeyTable& table);
void add_odometry_keys(vo::VoParams& odometry, KeyTable& table);
void add_daemon_keys(Config& config, KeyTable& table);

// All of them. The table points into `config`, which must outlive it and stay where it is.
KeyTable config_keys(Config& config);

}  // namespace cliquevo::daemon
