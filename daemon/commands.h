// SPDX-License-Identifier: BSD-3-Clause
// All ways to command the running daemon, and its answer to a request for its status.
#pragma once

#include <mutex>
#include <optional>
#include <string>

#include <cliquevo/health_t.hpp>

#include "daemon/control/command_receiver.h"
#include "daemon/control/control_socket.h"
#include "daemon/control/incidents.h"
#include "daemon/pipeline/config.h"
#include "daemon/recording.h"
#include "daemon/threads/pipeline.h"

namespace cliquevo::daemon {

class Commands {
 public:
  // Both outlive it.
  Commands(Pipeline& pipeline, Recording& recording) : pipeline_(pipeline), recording_(recording) {}
  Commands(const Commands&) = delete;
  Commands& operator=(const Commands&) = delete;

  // Opens what the configuration names. What cannot be opened is reported, and the daemon goes on without.
  void listen(const Config& config);
  void set_status(const health_t& health);
  Incidents& incidents() { return incidents_; }

 private:
  Result<std::string> handle(Command command);

  Pipeline& pipeline_;
  Recording& recording_;
  Incidents incidents_;
  std::mutex mutex_;
  std::string status_ = R"({"state":"starting"})";
  std::optional<ControlSocket> socket_;  // these two last: their threads use the rest
  std::optional<CommandReceiver> receiver_;
};

}  // namespace cliquevo::daemon
