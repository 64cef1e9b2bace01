// SPDX-License-Identifier: BSD-3-Clause
// The main thread while frames flow: feeds the watchdog, reports once a second, takes signals.
#pragma once

#include <functional>
#include <string>

#include "daemon/commands.h"
#include "daemon/output.h"
#include "daemon/recording.h"
#include "daemon/service.h"
#include "daemon/signals.h"
#include "daemon/threads/pipeline.h"

namespace cliquevo::daemon {

struct Watched {
  Pipeline& pipeline;
  Output& output;
  Recording& recording;
  Commands& commands;
  Service& service;
  std::string source;  // its description
};

// Until the source's end or a signal to stop; the pipeline is then stopped.
void watch(const Watched& watched, const Signals& signals, const std::function<void()>& on_hangup);

}  // namespace cliquevo::daemon
