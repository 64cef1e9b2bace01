// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/log.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/sinks/systemd_sink.h>
#include <spdlog/spdlog.h>

namespace cliquevo::daemon {

namespace {

// systemd sets it for a service whose stderr is the journal.
bool in_journal() { return std::getenv("JOURNAL_STREAM") != nullptr; }

}  // namespace

void set_up_log(const std::string& level) {
  std::shared_ptr<spdlog::sinks::sink> sink;
  if (in_journal()) {
    sink = std::make_shared<spdlog::sinks::systemd_sink_mt>("cliquevod");
  } else {
    sink = std::make_shared<spdlog::sinks::stderr_color_sink_mt>();
    sink->set_pattern("%H:%M:%S.%e %^%l%$ %v");
  }
  auto logger = std::make_shared<spdlog::logger>("cliquevod", std::move(sink));
  logger->set_level(spdlog::level::from_str(level));
  spdlog::set_default_logger(std::move(logger));
}

void report(const Error& error) {
  std::string line = error.line();
  std::replace(line.begin(), line.end(), '\n', ' ');
  if (in_journal()) {
    spdlog::error(line);
  } else {
    fmt::print(stderr, "{}\n", line);
  }
}

}  // namespace cliquevo::daemon
