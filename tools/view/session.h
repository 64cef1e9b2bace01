// SPDX-License-Identifier: BSD-3-Clause
// What the server keeps on a WebSocket: one a page or viewer.
#pragma once

namespace cliquevo::view {

class Session {
 public:
  virtual ~Session() = default;
  virtual void start() = 0;
  // Sends what is due, if nothing is on its way.
  virtual void pump() = 0;
  virtual bool open() const = 0;
};

}  // namespace cliquevo::view
