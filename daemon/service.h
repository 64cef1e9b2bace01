// SPDX-License-Identifier: BSD-3-Clause
// Reports of the daemon to systemd (sd_notify). Without systemd each call does nothing.
#pragma once

#include <cstdint>
#include <string>

namespace cliquevo::daemon {

class Service {
 public:
  // Whether systemd started this program and listens.
  static bool is_managed();
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
