// SPDX-License-Identifier: BSD-3-Clause
// The protocol of the control socket: a line per request (reset, record-start, record-stop, status), a line a reply:
// "ok" and a sentence (for status: JSON), or "error" and what: where: what to do.
#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "daemon/control/command.h"

namespace cliquevo::daemon {

struct ControlHandlers {
  CommandHandler command;
  std::function<std::string()> status;  // JSON in one line
};

// One peer, who may send anything.
class ControlSession {
 public:
  static constexpr std::size_t kLongestLine = 64;

  // handlers: outlive the session.
  explicit ControlSession(const ControlHandlers& handlers) : handlers_(handlers) {}
  // Bytes as they come; replies to the whole lines among them are added to `out`. false: no request, hang up.
  bool take(std::string_view bytes, std::string& out);

 private:
  std::string reply(std::string_view request) const;

  const ControlHandlers& handlers_;
  std::string line_;
};

}  // namespace cliquevo::daemon
