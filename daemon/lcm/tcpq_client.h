// SPDX-License-Identifier: BSD-3-Clause
// Messages to an LCM server over TCP (tcpq://). LCM's own client waits for ever for a server that accepts and sends
// nothing, or that reads nothing; this one waits for a moment, then leaves messages out.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/base/result.h"

namespace cliquevo::daemon {

class TcpqClient {
 public:
  // Resolves the host's address, then connects and greets: half a second each at most.
  static Result<std::unique_ptr<TcpqClient>> open(const std::string& url);
  ~TcpqClient();  // waits a moment for what is still to be sent
  TcpqClient(const TcpqClient&) = delete;
  TcpqClient& operator=(const TcpqClient&) = delete;

  // Any thread. false: left out. Waits for a slow server for 50 ms at most, for one that stands still not at all; a
  // lost connection is made anew.
  bool send(const std::string& channel, const std::uint8_t* data, std::size_t size);

 private:
  struct Impl;
  explicit TcpqClient(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::daemon
