// SPDX-License-Identifier: BSD-3-Clause
// What a fuzz target holds against the code: a promise broken aborts, which libFuzzer reports with the input.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace cliquevo::fuzz {

inline void expect(bool holds, std::string_view promise) {
  if (holds) return;
  std::fprintf(stderr, "broken: %.*s\n", static_cast<int>(promise.size()), promise.data());
  std::abort();
}

// Every error has its three parts and is one line.
inline void expect_clear(const Error& error) {
  const std::string line = error.line();
  expect(!error.what.empty() && !error.where.empty() && !error.remedy.empty(), "an error has three parts: " + line);
  if (line.find_first_of(std::string_view("\n\r\0", 3)) != std::string::npos)
    expect(false, "an error is one line: " + line);
}

}  // namespace cliquevo::fuzz
