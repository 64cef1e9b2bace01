// SPDX-License-Identifier: BSD-3-Clause
#include "tools/stop_on_signal.h"

namespace cliquevo::tools {

namespace {

volatile std::sig_atomic_t stop_signal = 0;

}  // namespace

StopOnSignal::StopOnSignal() {
  stop_signal = 0;
  struct sigaction action = {};
  action.sa_handler = [](int signal) { stop_signal = signal; };
  action.sa_flags = static_cast<int>(SA_RESETHAND);  // no SA_RESTART: it must end a sleep
  sigaction(SIGINT, &action, &old_interrupt_);
  sigaction(SIGTERM, &action, &old_terminate_);
}

StopOnSignal::~StopOnSignal() {
  sigaction(SIGINT, &old_interrupt_, nullptr);
  sigaction(SIGTERM, &old_terminate_, nullptr);
}

bool StopOnSignal::asked() { return stop_signal != 0; }

}  // namespace cliquevo::tools
