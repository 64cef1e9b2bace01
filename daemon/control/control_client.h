// SPDX-License-Identifier: BSD-3-Clause
// The other end of the control socket.
#pragma once

#include <string>
#include <sys/un.h>

#include "core/base/result.h"
#include "daemon/control/file_descriptor.h"

namespace cliquevo::daemon {

// Fails when the path is too long for a socket.
Result<sockaddr_un> control_address(const std::string& path);
Result<FileDescriptor> connect_control(const std::string& path);
// Sends the request's line and returns what follows "ok " in the reply; "error ..." is an error, as is no reply within
// timeout_s.
Result<std::string> ask_daemon(const std::string& path, const std::string& request, double timeout_s = 10.0);

}  // namespace cliquevo::daemon
