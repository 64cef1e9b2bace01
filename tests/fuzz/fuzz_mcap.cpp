// SPDX-License-Identifier: BSD-3-Clause
// An MCAP as a file: every message read, and played as a recording where it is one.
#include "tests/fuzz/bag_input.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  cliquevo::fuzz::play_bag(data, size);
  return 0;
}
