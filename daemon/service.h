// SPDX-License-Identifier: BSD-3-Clause
// What the daemon tells systemd (sd_notify). Without systemd each call does nothing.
#pragma once

#include <cstdint>
#include <string>

namespace cliquevo::daemon {

class Service {
 public:
  void ready();  // once; later calls do nothing
  void status(const std::string& text);
  void feed_watchdog();
  void reloading();
  void reloaded();
  void stopping();

 private:
  bool is_ready_ = false;
};

}  // namespace cliquevo::daemon
