// SPDX-License-Identifier: BSD-3-Clause
// The Unix socket by which `cliquevo ctl` speaks to the daemon; for its owner and group alone.
#pragma once

#include <memory>
#include <string>

#include "core/base/result.h"
#include "daemon/control/control_session.h"

namespace cliquevo::daemon {

class ControlSocket {
 public:
  // Listens on a thread of its own. A socket that a dead daemon left behind is replaced, that of a live one is not.
  static Result<ControlSocket> open(const std::string& path, ControlHandlers handlers);
  ControlSocket(ControlSocket&&) noexcept;
  ControlSocket& operator=(ControlSocket&&) = delete;
  ~ControlSocket();  // removes it

 private:
  struct Impl;
  explicit ControlSocket(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::daemon
