// SPDX-License-Identifier: BSD-3-Clause
#include "tools/stop_on_signal.h"

#include <algorithm>
#include <ctime>

#include "core/base/time.h"

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

bool StopOnSignal::received() { return stop_signal != 0; }

void StopOnSignal::sleep_until(std::int64_t due_mono_ns) {
  constexpr std::int64_t kStepNs = 50'000'000;  // a signal that comes just before the sleep begins does not end it
  while (!received()) {
    const std::int64_t left_ns = std::min(due_mono_ns - monotonic_ns(), kStepNs);
    if (left_ns <= 0) return;
    const timespec pause = {0, static_cast<long>(left_ns)};
    nanosleep(&pause, nullptr);
  }
}

}  // namespace cliquevo::tools
