// SPDX-License-Identifier: BSD-3-Clause
// Errors as values: what went wrong, where, and what to do about it; the command line prints them as one line.
#pragma once

#include <cassert>
#include <optional>
#include <string>
#include <utility>
#include <variant>

namespace cliquevo {

// What went wrong, where, and what to do about it: three parts of one line.
struct Error {
  std::string what;    // "cannot read image"
  std::string where;   // "/data/run1/image_0/000012.png"
  std::string remedy;  // "copy the recording again: the file is torn"

  // "what: where: what to do"
  std::string line() const { return what + ": " + where + ": " + remedy; }
};

// A value or an error. Result<void> carries only success or an error.
template <typename T>
class [[nodiscard]] Result {
 public:
  // Success.
  Result(T value) : state_(std::move(value)) {}  // NOLINT(google-explicit-constructor)
  // Failure.
  Result(Error error) : state_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  // Whether there is a value. An error is looked at only where there is none, and the other way round.
  bool ok() const { return std::holds_alternative<T>(state_); }
  // ok()
  explicit operator bool() const { return ok(); }
  // The value; only where ok().
  T& value() {
    assert(ok());
    return *std::get_if<T>(&state_);
  }
  // The value; only where ok().
  const T& value() const {
    assert(ok());
    return *std::get_if<T>(&state_);
  }
  // The error; only where not ok().
  const Error& error() const {
    assert(!ok());
    return *std::get_if<Error>(&state_);
  }
  T* operator->() { return &value(); }              // value()
  const T* operator->() const { return &value(); }  // value()
  T& operator*() { return value(); }                // value()
  const T& operator*() const { return value(); }    // value()

 private:
  std::variant<T, Error> state_;
};

// Success or an error.
template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  // Failure.
  Result(Error error) : error_(std::move(error)) {}  // NOLINT(google-explicit-constructor)

  // Whether it succeeded.
  bool ok() const { return !error_.has_value(); }
  // ok()
  explicit operator bool() const { return ok(); }
  // The error; only where not ok().
  const Error& error() const {
    assert(!ok());
    return *error_;
  }

 private:
  std::optional<Error> error_;
};

}  // namespace cliquevo
