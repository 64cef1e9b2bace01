// SPDX-License-Identifier: BSD-3-Clause
// GLib's objects with C++ lifetimes.
#pragma once

#include <arv.h>
#include <memory>
#include <string>

namespace cliquevo::drivers {

struct Unref {
  void operator()(void* object) const { g_object_unref(object); }
};
template <typename T>
using Handle = std::unique_ptr<T, Unref>;

// Takes the error that a call left.
class GlibError {
 public:
  GlibError() = default;
  ~GlibError() { g_clear_error(&error_); }
  GlibError(const GlibError&) = delete;
  GlibError& operator=(const GlibError&) = delete;
  GError** out() {
    g_clear_error(&error_);
    return &error_;
  }
  bool failed() const { return error_ != nullptr; }
  bool is(GQuark domain, int code) const { return error_ != nullptr && g_error_matches(error_, domain, code) != 0; }
  std::string text() const { return error_ != nullptr ? error_->message : ""; }

 private:
  GError* error_ = nullptr;
};

}  // namespace cliquevo::drivers
