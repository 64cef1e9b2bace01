// SPDX-License-Identifier: BSD-3-Clause
// The view: a feed, a store, a server.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "core/base/result.h"
#include "tools/view/feed.h"
#include "tools/view/server.h"

namespace cliquevo::view {

struct ViewOptions {
  ServerOptions server;
  std::int64_t keep_mb = 2048;  // of pictures
  std::string control_socket;   // of the daemon; empty = pages give no commands
  std::string version;
  bool open_browser = false;
};

// Serves until `stopped`; `announce` gets the address once pages may come.
Result<void> run_view(std::unique_ptr<Feed> feed, const ViewOptions& options,
                      const std::function<void(const std::string& address)>& announce,
                      const std::function<bool()>& stopped);

}  // namespace cliquevo::view
