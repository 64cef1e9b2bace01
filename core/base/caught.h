// SPDX-License-Identifier: BSD-3-Clause
// Exceptions of libraries as errors: for the entry of every thread, and around whatever may throw.
#pragma once

#include <atomic>
#include <chrono>
#include <exception>
#include <new>
#include <string>
#include <thread>
#include <utility>

#include "core/base/result.h"

namespace cliquevo {

inline constexpr const char* kCaught = "cannot go on";
// Whether an error is an exception that nobody expected.
inline bool is_caught(const Error& error) { return error.what == kCaught; }

// The exception being handled as an Error; call it in a catch block. The texts of "out of memory" need no memory.
inline Error caught(const std::string& where) {
  try {
    throw;
  } catch (const std::bad_alloc&) {
    return {kCaught, where, "no memory left"};
  } catch (const std::exception& exception) {
    return {kCaught, where, exception.what()};
  } catch (...) {
    return {kCaught, where, "unknown error"};
  }
}

// work() returns a Result; one that throws returns the error instead.
template <typename Work>
auto guarded(const char* where, Work&& work) -> decltype(work()) {
  try {
    return std::forward<Work>(work)();
  } catch (...) {
    return caught(where);
  }
}

// body() until it returns; what it throws goes to report(Error), and after a pause it is called again unless `stop` is
// set meanwhile. For threads that must live.
template <typename Body, typename Report>
void keep_going(const char* where, const std::atomic<bool>& stop, const Body& body, const Report& report) {
  const auto attempt = [&](const auto& work) { return guarded(where, [&] { return work(), Result<void>(); }); };
  for (Result<void> done = attempt(body); !done.ok() && !stop; done = attempt(body)) {
    static_cast<void>(attempt([&] { report(done.error()); }));
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
  }
}

}  // namespace cliquevo
