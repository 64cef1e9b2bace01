// SPDX-License-Identifier: BSD-3-Clause
#include "tools/fleet/isolated.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/caught.h"
#include "tools/stop_on_signal.h"

namespace cliquevo::tools::fleet {

namespace {

using nlohmann::json;

constexpr off_t kMostSaid = 4096;
constexpr int kFailed = 1;

// A file in memory that parent and child share: no pipe has to be emptied meanwhile.
class SharedText {
 public:
  explicit SharedText(const char* name) : descriptor_(::memfd_create(name, MFD_CLOEXEC)) {}
  ~SharedText() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  SharedText(const SharedText&) = delete;
  SharedText& operator=(const SharedText&) = delete;

  int descriptor() const { return descriptor_; }
  // The last of it.
  std::string tail() const {
    const off_t size = ::lseek(descriptor_, 0, SEEK_END);
    const off_t begin = std::max<off_t>(0, size - kMostSaid);
    std::string out(static_cast<std::size_t>(std::max<off_t>(0, size - begin)), '\0');
    const ssize_t got = ::pread(descriptor_, out.data(), out.size(), begin);
    out.resize(static_cast<std::size_t>(std::max<ssize_t>(0, got)));
    return out;
  }

 private:
  int descriptor_;
};

[[noreturn]] void run_child(const std::function<Result<void>()>& work, pid_t parent, const SharedText& said,
                            const SharedText& error) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(kFailed);  // it ended before the line above
  ::dup2(said.descriptor(), STDOUT_FILENO);
  ::dup2(said.descriptor(), STDERR_FILENO);
  const Result<void> done = guarded("unit", work);
  std::fflush(nullptr);
  if (done) ::_exit(0);
  const Error& e = done.error();
  const std::string text = json{e.what, e.where, e.remedy}.dump(-1, ' ', false, json::error_handler_t::replace);
  const bool reported = ::write(error.descriptor(), text.data(), text.size()) == static_cast<ssize_t>(text.size());
  ::_exit(reported ? kFailed : kFailed + 1);
}

int wait_for(pid_t child) {
  int status = 0;
  bool passed_on = false;
  while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    if (StopOnSignal::received() && !passed_on) ::kill(child, SIGTERM);
    passed_on = passed_on || StopOnSignal::received();
  }
  return status;
}

std::optional<Error> reported_error(const std::string& text) {
  const json parts = json::parse(text, nullptr, false);
  if (!parts.is_array() || parts.size() != 3) return std::nullopt;
  for (const json& part : parts) {
    if (!part.is_string()) return std::nullopt;
  }
  return Error{parts[0], parts[1], parts[2]};
}

}  // namespace

IsolatedEnd run_isolated(const std::function<Result<void>()>& work, const Error& crash) {
  IsolatedEnd out;
  const SharedText said("said");
  const SharedText error("error");
  std::fflush(nullptr);  // else the child prints it again
  const pid_t parent = ::getpid();
  const pid_t child = ::fork();
  if (child == 0) run_child(work, parent, said, error);
  if (child < 0) {
    out.error = Error{fmt::format("cannot begin a process ({})", std::strerror(errno)), crash.where,
                      "see the limits of processes and memory (ulimit -a)"};
    return out;
  }
  const int status = wait_for(child);
  out.said = said.tail();
  if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return out;
  out.error = reported_error(error.tail());
  if (WIFEXITED(status) && out.error) return out;
  out.crashed = true;
  const std::string how = WIFSIGNALED(status)
                              ? fmt::format("signal {}, {}", WTERMSIG(status), ::strsignal(WTERMSIG(status)))
                              : fmt::format("exit code {}", WEXITSTATUS(status));
  out.error = Error{fmt::format("{} ({})", crash.what, how), crash.where, crash.remedy};
  return out;
}

}  // namespace cliquevo::tools::fleet
