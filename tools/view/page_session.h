// SPDX-License-Identifier: BSD-3-Clause
// One page's WebSocket.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "tools/view/access.h"
#include "tools/view/server.h"
#include "tools/view/session.h"
#include "tools/view/store.h"
#include "tools/view/web_socket.h"

namespace cliquevo::view {

// What all pages get, made once for all of them.
struct SharedState {
  std::shared_ptr<const std::string> state;
  std::shared_ptr<const std::string> mask;
};

class PageSession final : public Session, public std::enable_shared_from_this<PageSession> {
 public:
  PageSession(std::unique_ptr<WebSocket> socket, const Store& store, const PageContent& content,
              const SharedState& shared);
  void start() override;
  void pump() override;
  bool open() const override { return open_; }
  void close();

 private:
  void read();
  void take(const std::string& text);
  void send(std::string message, bool text);
  std::optional<std::string> next_text();

  const std::unique_ptr<WebSocket> socket_;
  const Store& store_;
  const PageContent& content_;
  const SharedState& shared_;
  std::string outgoing_;
  bool open_ = false;
  bool writing_ = false;
  bool greeted_ = false;
  std::int64_t next_record_ = 0;
  std::optional<PageCommand> wanted_;  // the newest request wins
  SharedState has_;                    // what all have
};

}  // namespace cliquevo::view
