// SPDX-License-Identifier: BSD-3-Clause
// Calibrations and times files of every format; the first byte chooses the file's name.
#include "tests/fuzz/expect.h"
#include "tests/fuzz/recording_parsers.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bad = cliquevo::fuzz::parse_anything(data, size);
  cliquevo::fuzz::expect(bad.empty(), bad);
  return 0;
}
