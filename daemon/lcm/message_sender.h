// SPDX-License-Identifier: BSD-3-Clause
// Bytes out on a channel, whatever the URL's transport. Nothing is received, and no transport waits for a peer for
// long.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/base/result.h"

namespace cliquevo::daemon {

class MessageSender {
 public:
  virtual ~MessageSender() = default;
  // Any thread. false: not sent.
  virtual bool send(const std::string& channel, const std::uint8_t* data, std::size_t size) = 0;

  // Fails when the URL cannot be used: see check_lcm_url().
  static Result<std::unique_ptr<MessageSender>> open(const std::string& url);
};

}  // namespace cliquevo::daemon
