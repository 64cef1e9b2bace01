// SPDX-License-Identifier: BSD-3-Clause
// What a fuzz target holds against the code: a promise broken aborts, which libFuzzer reports with the input.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>

#include "core/base/result.h"

namespace cliquevo::fuzz {

inline void expect(bool holds, const std::string& promise) {
  if (holds) return;
  std::fprintf(stderr, "broken: %s\n", promise.c_str());
  std::abort();
}

// Every error has its three parts and is one line.
inline void expect_clear(const Error& error) {
  const std::string line = error.line();
  expect(!error.what.empty() && !error.where.empty() && !error.remedy.empty(), "an error has three parts: " + line);
  for (const char c : line) expect(c != '\n' && c != '\r' && c != '\0', "an error is one line: " + line);
}

}  // namespace cliquevo::fuzz
