// SPDX-License-Identifier: BSD-3-Clause
// A WebSocket that the server keeps: whole messages, one at a time each way.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

namespace cliquevo::view {

// Everything happens on the server's thread. What is to be done afterwards is called once and later, never by the
// function that it was given to; it must keep alive who owns the socket.
class WebSocket {
 public:
  struct Message {
    std::string content;
    bool text = false;
  };
  virtual ~WebSocket() = default;
  virtual void accept(std::function<void(bool ok)> done) = 0;
  // nullopt: the other side has gone, is silent or does not keep to the protocol.
  virtual void read(std::function<void(std::optional<Message>)> done) = 0;
  // One message: head and body, which must stay where they are until it is done.
  virtual void write(std::string_view head, std::string_view body, bool text, std::function<void(bool ok)> done) = 0;
  virtual void close() = 0;
};

}  // namespace cliquevo::view
