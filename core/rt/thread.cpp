// SPDX-License-Identifier: BSD-3-Clause
#include "core/rt/thread.h"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <limits.h>
#include <pthread.h>
#include <sched.h>
#include <unistd.h>
#include <utility>

#include "core/base/caught.h"
#include "core/base/printable.h"
#include "core/rt/memory.h"

namespace cliquevo::rt {

struct Thread::Impl {
  std::string name;
  std::function<void()> body;
  std::size_t prefault_bytes = 0;
  pthread_t handle{};
};

namespace {

void note(std::string& shortfall, const std::string& what, int error) {
  if (error == 0) return;
  if (!shortfall.empty()) shortfall += "; ";
  shortfall += what + ": " + std::strerror(error);
}

std::atomic<int> code_of_exceptions{1};  // of a bad environment

// The last resort for a body that lets an exception out: one line, and an exit code.
[[noreturn]] void end_program(const Error& error) {
  const std::string line = printable(error.line()) + "\n";
  if (::write(STDERR_FILENO, line.data(), line.size()) < 0) std::_Exit(code_of_exceptions);
  std::_Exit(code_of_exceptions);
}

}  // namespace

void exceptions_end_with(int exit_code) { code_of_exceptions = exit_code; }

std::string schedule(std::thread::native_handle_type thread, const ThreadOptions& options) {
  std::string shortfall;
  pthread_setname_np(thread, options.name.substr(0, 15).c_str());
  if (options.cpu >= 0) {
    cpu_set_t cores;
    CPU_ZERO(&cores);
    if (options.cpu < CPU_SETSIZE) CPU_SET(static_cast<std::size_t>(options.cpu), &cores);
    note(shortfall, "core " + std::to_string(options.cpu), pthread_setaffinity_np(thread, sizeof cores, &cores));
  }
  if (options.fifo_priority > 0) {
    sched_param priority{};
    priority.sched_priority = options.fifo_priority;
    note(shortfall, "FIFO priority " + std::to_string(options.fifo_priority),
         pthread_setschedparam(thread, SCHED_FIFO, &priority));
  }
  return shortfall;
}

Result<Thread> Thread::start(const ThreadOptions& options, std::function<void()> body) {
  Thread thread;
  thread.impl_ = std::make_unique<Impl>();
  Impl* impl = thread.impl_.get();
  impl->name = options.name;
  impl->body = std::move(body);
  const std::size_t stack = std::max<std::size_t>(options.stack_bytes, PTHREAD_STACK_MIN);
  impl->prefault_bytes = stack / 2;

  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_attr_setstacksize(&attributes, stack);
  const auto run = [](void* argument) -> void* {
    auto* self = static_cast<Impl*>(argument);
    prefault_stack(self->prefault_bytes);
    try {
      self->body();
    } catch (...) {
      end_program(caught(self->name));
    }
    return nullptr;
  };
  const int failed = pthread_create(&impl->handle, &attributes, run, impl);
  pthread_attr_destroy(&attributes);
  if (failed != 0) {
    thread.impl_.reset();
    return Error{"cannot start a thread", options.name, std::strerror(failed)};
  }

  thread.shortfall_ = schedule(impl->handle, options);
  return thread;
}

Thread::Thread() noexcept = default;
Thread::Thread(Thread&&) noexcept = default;

Thread& Thread::operator=(Thread&& other) noexcept {
  if (this != &other) {
    join();
    impl_ = std::move(other.impl_);
    shortfall_ = std::move(other.shortfall_);
  }
  return *this;
}

Thread::~Thread() { join(); }

void Thread::join() {
  if (!impl_) return;
  pthread_join(impl_->handle, nullptr);
  impl_.reset();
}

}  // namespace cliquevo::rt
