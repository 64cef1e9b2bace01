// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/service.h"

#include <cstdlib>
#include <systemd/sd-daemon.h>

#include "core/base/printable.h"

namespace cliquevo::daemon {

bool Service::is_managed() { return std::getenv("NOTIFY_SOCKET") != nullptr; }

void Service::ready() {
  if (is_ready_) return;
  is_ready_ = true;
  sd_notify(0, "READY=1");
}

void Service::status(const std::string& text) { sd_notify(0, ("STATUS=" + printable(text)).c_str()); }
void Service::feed_watchdog() { sd_notify(0, "WATCHDOG=1"); }
void Service::reloading() {
  if (is_ready_) sd_notify(0, "RELOADING=1");
}
void Service::reloaded() {
  if (is_ready_) sd_notify(0, "READY=1");
}
void Service::stopping() { sd_notify(0, "STOPPING=1"); }

}  // namespace cliquevo::daemon
