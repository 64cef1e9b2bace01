// SPDX-License-Identifier: BSD-3-Clause
// libFuzzer's entry: build with clang and -DCLIQUEVO_BUILD_FUZZERS=ON, run build/<preset>/bin/fuzz_recording_parsers.
#include <cstdio>
#include <cstdlib>

#include "tests/fuzz/recording_parsers.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bad = cliquevo::fuzz::parse_anything(data, size);
  if (!bad.empty()) {
    std::fprintf(stderr, "%s\n", bad.c_str());
    std::abort();
  }
  return 0;
}
