// SPDX-License-Identifier: BSD-3-Clause
#include "core/rt/memory.h"

#include <algorithm>
#include <alloca.h>
#include <cerrno>
#include <cstring>
#include <limits>
#include <linux/capability.h>
#include <malloc.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

namespace cliquevo::rt {

namespace {

// A process with this capability may exceed the limit.
bool has_lock_capability() {
  __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
  __user_cap_data_struct data[_LINUX_CAPABILITY_U32S_3] = {};
  if (::syscall(SYS_capget, &header, data) != 0) return false;
  return (data[CAP_TO_INDEX(CAP_IPC_LOCK)].effective & CAP_TO_MASK(CAP_IPC_LOCK)) != 0;
}

}  // namespace

std::string lock_memory() {
  // Under a limit, locking what comes later would make allocations fail instead.
  rlimit limit{};
  if (!has_lock_capability() && ::getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY) {
    return "locked memory is limited to " + std::to_string(limit.rlim_cur / 1024) + " kB (ulimit -l)";
  }
  // Memory given back to the kernel would fault again when taken anew; so would every block that has a mapping of its
  // own.
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
  mallopt(M_MMAP_MAX, 0);
  if (::mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return {};
  return std::string("mlockall: ") + std::strerror(errno);
}

namespace {

constexpr std::size_t kPage = 4096;
constexpr std::size_t kMargin = 16 * kPage;  // for the calls made here

// How far the stack may still grow. Less than its size: thread-local storage lies in it too.
std::size_t stack_left() {
  pthread_attr_t attributes;
  if (pthread_getattr_np(pthread_self(), &attributes) != 0) return 0;
  void* lowest = nullptr;
  std::size_t size = 0;
  pthread_attr_getstack(&attributes, &lowest, &size);
  pthread_attr_destroy(&attributes);
  const auto* here = static_cast<const char*>(__builtin_frame_address(0));
  return static_cast<std::size_t>(here - static_cast<const char*>(lowest));
}

// Not inlined: alloca lasts until the function that it lands in returns.
[[gnu::noinline]] void touch_stack(std::size_t bytes) {
  auto* stack = static_cast<volatile char*>(alloca(bytes));
  for (std::size_t i = 0; i < bytes; i += kPage) stack[i] = 0;
}

}  // namespace

void prefault_stack(std::size_t most) {
  const std::size_t left = stack_left();
  if (left > 2 * kMargin) touch_stack(std::min(most, left - kMargin));
}

}  // namespace cliquevo::rt
