// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/libcamera/log_filter.h"

#include <cstdlib>
#include <ostream>
#include <streambuf>
#include <string_view>
#include <unistd.h>

// clang-format off: it names std::ostream without including it.
#include <libcamera/logging.h>
// clang-format on

namespace cliquevo::drivers {

namespace {

// libcamera writes each message at once: "[time] [thread] LEVEL category file:line text".
class OnlyErrors : public std::streambuf {
 protected:
  std::streamsize xsputn(const char* text, std::streamsize size) override {
    const std::string_view message(text, static_cast<std::size_t>(size));
    const bool severe =
        message.find(" ERROR ") != std::string_view::npos || message.find(" FATAL ") != std::string_view::npos;
    if (severe) (void)!::write(STDERR_FILENO, text, message.size());  // what cannot be shown is lost
    return size;
  }
  int overflow(int c) override { return c; }
};

}  // namespace

void show_only_errors_of_libcamera() {
  if (std::getenv("LIBCAMERA_LOG_LEVELS") != nullptr || std::getenv("LIBCAMERA_LOG_FILE") != nullptr) return;
  static auto* const stream = new std::ostream(new OnlyErrors);  // libcamera may write until the very end
  libcamera::logSetStream(stream);
}

}  // namespace cliquevo::drivers
