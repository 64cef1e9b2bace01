// SPDX-License-Identifier: BSD-3-Clause
// Listens for VO_COMMAND.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include <cliquevo/command_t.hpp>

#include "core/base/result.h"

namespace cliquevo::daemon {

class CommandReceiver {
 public:
  // on_command is called on a thread of the receiver's own. On a URL that only writes (a log), nothing ever comes.
  static Result<CommandReceiver> start(const std::string& url, const std::string& channel,
                                       std::function<void(const command_t&)> on_command);
  CommandReceiver(CommandReceiver&&) noexcept;
  CommandReceiver& operator=(CommandReceiver&&) = delete;
  ~CommandReceiver();

 private:
  struct Impl;
  explicit CommandReceiver(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::daemon
