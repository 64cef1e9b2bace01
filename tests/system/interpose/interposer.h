// SPDX-License-Identifier: BSD-3-Clause
// Counts what a real-time thread must not do. Linking interposer.cpp into a program puts these functions in front of
// the C library's; a thread that is being watched counts its calls, all others pay one look at a flag.
#pragma once

#include <cstdint>

namespace cliquevo::test {

struct ForbiddenCalls {
  std::int64_t allocations = 0;   // malloc, free, ... and what is built on them
  std::int64_t locks = 0;         // mutexes, condition variables, semaphores
  std::int64_t input_output = 0;  // open, read, write, stat, sync, ...
  std::int64_t minor_faults = 0;
  std::int64_t major_faults = 0;
  const char* first = nullptr;  // name of the first forbidden function called
};

// From here on the calling thread's calls are counted.
void watch_this_thread();
// What the calling thread has done since; call it on the thread that is being watched.
ForbiddenCalls calls_of_this_thread();

}  // namespace cliquevo::test
