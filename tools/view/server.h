// SPDX-License-Identifier: BSD-3-Clause
// HTTP and WebSocket for the page, and for viewers that speak foxglove.websocket.v1, on one thread. A page asks for
// frames and gets each when the one before has gone out: one that is slow skips frames, and nothing waits for it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "tools/view/access.h"
#include "tools/view/ros2_topics.h"
#include "tools/view/store.h"

namespace cliquevo::view {

struct ServerOptions {
  std::string listen = "127.0.0.1";
  std::uint16_t port = 8470;  // 0: any that is free
  // Origins of pages that may connect as viewers, e.g. "http://localhost:8080".
  std::vector<std::string> viewer_origins;
  std::string version;  // sent to viewers
};

// What the server sends pages beside frames. Called on the server's thread; none may wait.
struct PageContent {
  std::function<std::string()> hello;  // JSON object, once a page
  // JSON object; pages get it when its text has changed.
  std::function<std::string()> state;
  // JSON object; pages get it when it is another one. nullptr: nothing to send.
  std::function<std::shared_ptr<const std::string>()> mask;
  // What /metrics answers, in Prometheus' text format.
  std::function<std::string()> metrics;
  // Does what was asked for; what comes of it is in the state.
  std::function<void(PageCommand::What)> command;
};

class Server {
 public:
  // Fails when the address cannot be had. Where it is not loopback, a token is made and asked for.
  static Result<std::unique_ptr<Server>> open(const ServerOptions& options, const Store& store, Ros2Topics& topics,
                                              PageContent content);
  virtual ~Server() = default;
  // "http://127.0.0.1:8470/", with the token where one is asked for.
  virtual std::string address() const = 0;
  // Serves until `stopped` says so, which is asked ten times a second and more.
  virtual void run(const std::function<bool()>& stopped) = 0;
};

}  // namespace cliquevo::view
