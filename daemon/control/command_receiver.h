// SPDX-License-Identifier: BSD-3-Clause
// Listens for VO_COMMAND, where that is switched on. Anybody who reaches the group can send: packets are taken of this
// machine alone while the URL's ttl is 0, only whole and short ones, and only some a second. LCM's own receiver is not
// used: a crafted packet makes it write beyond its memory.
#pragma once

#include <memory>
#include <string>

#include "core/base/result.h"
#include "daemon/control/command.h"
#include "daemon/control/incidents.h"

namespace cliquevo::daemon {

class CommandReceiver {
 public:
  // For udpm URLs. handler is called on a thread of the receiver's own; what was not taken goes to `incidents`.
  static Result<CommandReceiver> start(const std::string& url, const std::string& channel, CommandHandler handler,
                                       Incidents& incidents);
  CommandReceiver(CommandReceiver&&) noexcept;
  CommandReceiver& operator=(CommandReceiver&&) = delete;
  ~CommandReceiver();

 private:
  struct Impl;
  explicit CommandReceiver(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::daemon
