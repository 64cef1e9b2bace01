// SPDX-License-Identifier: BSD-3-Clause
#include "tools/python/errors.h"

#include "core/base/printable.h"

namespace cliquevo::python {

namespace {

// Lives as long as the interpreter.
PyObject* error_class = nullptr;

}  // namespace

void raise(const Error& error) {
  const Error clean = printable(error);
  const py::object exception = py::reinterpret_borrow<py::object>(error_class)(clean.line());
  exception.attr("what") = clean.what;
  exception.attr("where") = clean.where;
  exception.attr("remedy") = clean.remedy;
  PyErr_SetObject(error_class, exception.ptr());
  throw py::error_already_set();
}

void raise_type(const Error& error) { throw py::type_error(printable(error).line()); }

std::string text_for_python(const std::string& text) { return printable(text); }

void bind_errors(py::module_& module) {
  py::dict parts;
  for (const char* part : {"what", "where", "remedy"}) parts[part] = "";
  error_class = PyErr_NewExceptionWithDoc(
      "cliquevo.Error",
      "Bad input or environment. str() is one line, `what: where: what to do`, as the command prints.",
      PyExc_ValueError, parts.ptr());
  if (error_class == nullptr) throw py::error_already_set();
  module.attr("Error") = py::reinterpret_borrow<py::object>(error_class);
}

}  // namespace cliquevo::python
