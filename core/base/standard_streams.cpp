// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/standard_streams.h"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <fcntl.h>
#include <iostream>
#include <unistd.h>

#include "core/base/printable.h"

namespace cliquevo {

void keep_standard_streams() {
  std::signal(SIGPIPE, SIG_IGN);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (::fcntl(stream, F_GETFD) >= 0 || errno != EBADF) continue;
    // The lowest free number is this one: those below it are open.
    const int opened = ::open("/dev/null", stream == STDERR_FILENO ? O_WRONLY : O_RDONLY);
    if (opened != stream && opened >= 0) ::close(opened);
  }
}

Result<void> flush_stdout() {
  errno = 0;
  std::cout.flush();
  const bool written = std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout.good();
  if (written) return {};
  const std::string why = errno != 0 ? std::strerror(errno) : "it took only a part";
  return Error{"cannot write", "standard output", why};
}

void print_error_line(const std::string& line) noexcept {
  try {
    const std::string whole = printable(line) + "\n";
    std::fflush(stderr);
    std::size_t done = 0;
    while (done < whole.size()) {
      const ssize_t written = ::write(STDERR_FILENO, whole.data() + done, whole.size() - done);
      if (written < 0 && errno == EINTR) continue;
      if (written <= 0) return;
      done += static_cast<std::size_t>(written);
    }
  } catch (...) {  // no memory for the line: the exit code still shows the failure
  }
}

}  // namespace cliquevo
