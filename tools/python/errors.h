// SPDX-License-Identifier: BSD-3-Clause
// Errors as Python exceptions, with the sentence that the command prints.
#pragma once

#include <pybind11/pybind11.h>
#include <string>
#include <utility>

#include "core/base/result.h"

namespace cliquevo::python {

namespace py = pybind11;

// Raises cliquevo.Error: str() is the error's line; what, where and remedy are its parts.
[[noreturn]] void raise(const Error& error);
// Raises TypeError with that line: an argument is of the wrong kind.
[[noreturn]] void raise_type(const Error& error);

template <typename T>
T value_of(Result<T> result) {
  if (!result) raise(result.error());
  return std::move(*result);
}
inline void check(const Result<void>& result) {
  if (!result) raise(result.error());
}

// Text from outside, fit for a Python str.
std::string text_for_python(const std::string& text);

void bind_errors(py::module_& module);

}  // namespace cliquevo::python
