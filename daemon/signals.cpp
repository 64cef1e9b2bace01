// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/signals.h"

#include <ctime>
#include <initializer_list>
#include <pthread.h>

namespace cliquevo::daemon {

Signals::Signals() {
  sigemptyset(&set_);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&set_, signal);
  pthread_sigmask(SIG_BLOCK, &set_, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
}

int Signals::wait(std::int64_t timeout_ns) const {
  timespec timeout{};
  timeout.tv_sec = timeout_ns / 1'000'000'000;
  timeout.tv_nsec = timeout_ns % 1'000'000'000;
  const int signal = sigtimedwait(&set_, nullptr, &timeout);
  return signal > 0 ? signal : 0;  // timed out, or interrupted by something else
}

}  // namespace cliquevo::daemon
