// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/control/control_session.h"

#include <fmt/format.h>

#include "core/base/caught.h"
#include "core/base/printable.h"

namespace cliquevo::daemon {

namespace {

std::string error_line(const Error& error) { return "error " + printable(error.line()) + "\n"; }

}  // namespace

bool ControlSession::take(std::string_view bytes, std::string& out) {
  for (const char c : bytes) {
    if (c == '\n') {
      out += reply(line_);
      line_.clear();
    } else if (line_.size() == kLongestLine) {
      out += error_line({"no request", "line too long", "send reset, record-start, record-stop or status"});
      return false;
    } else {
      line_ += c;
    }
  }
  return true;
}

std::string ControlSession::reply(std::string_view request) const {
  if (request.ends_with('\r')) request.remove_suffix(1);
  const auto done = guarded("control socket", [&]() -> Result<std::string> {
    if (request == "status") return handlers_.status();
    if (const auto command = command_of_word(request)) return handlers_.command(*command);
    return Error{"no request", fmt::format("'{}'", request), "send reset, record-start, record-stop or status"};
  });
  return done ? "ok " + printable(*done) + "\n" : error_line(done.error());
}

}  // namespace cliquevo::daemon
