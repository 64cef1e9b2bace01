// SPDX-License-Identifier: BSD-3-Clause
// Memory that is there when a real-time thread touches it.
#pragma once

#include <cstddef>
#include <string>

namespace cliquevo::rt {

// Once, at start, before the large buffers are made: all of the process's memory, now and later, is faulted in and kept
// from being swapped, and malloc keeps what it has instead of handing it back. Empty: done; otherwise why not (the
// process goes on without).
std::string lock_memory();

// Touches what is left of the calling thread's stack, up to `most` bytes, so that the pages are there.
void prefault_stack(std::size_t most);

}  // namespace cliquevo::rt
