// SPDX-License-Identifier: BSD-3-Clause
// Messages as they come, for commands that only listen.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <string>

#include "core/base/result.h"

namespace cliquevo::tools {

struct ReceivedMessage {
  std::string channel;
  const void* data = nullptr;
  std::size_t size = 0;
};

class LcmListener {
 public:
  // channels: a regular expression, as LCM takes it. Fails where there is no route, in one line.
  static Result<LcmListener> open(const std::string& url, const std::string& channels,
                                  std::function<void(const ReceivedMessage&)> handler);
  LcmListener(LcmListener&&) noexcept;
  LcmListener& operator=(LcmListener&&) noexcept;
  ~LcmListener();

  // Waits so long for a message and hands it on; an error when none can come any more.
  Result<void> wait(int milliseconds);

 private:
  struct Impl;
  explicit LcmListener(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::tools
