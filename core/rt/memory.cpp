// SPDX-License-Identifier: BSD-3-Clause
#include "core/rt/memory.h"

#include <alloca.h>
#include <cerrno>
#include <cstring>
#include <limits>
#include <malloc.h>
#include <sys/mman.h>

namespace cliquevo::rt {

std::string lock_memory() {
  // Memory given back to the kernel would fault again when taken anew; so would every block that has a mapping of its
  // own.
  mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
  mallopt(M_MMAP_MAX, 0);
  if (::mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return {};
  return std::string("mlockall: ") + std::strerror(errno);
}

// Not inlined: alloca lasts until the function that it lands in returns.
[[gnu::noinline]] void prefault_stack(std::size_t bytes) {
  constexpr std::size_t kPage = 4096;
  auto* stack = static_cast<volatile char*>(alloca(bytes));
  for (std::size_t i = 0; i < bytes; i += kPage) stack[i] = 0;
}

}  // namespace cliquevo::rt
