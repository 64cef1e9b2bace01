// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

#include <fmt/format.h>

#include "core/base/time.h"
#include "tools/fleet/engine.h"
#include "tools/fleet/progress_text.h"
#include "tools/stop_on_signal.h"

extern char** environ;  // NOLINT(readability-redundant-declaration)

namespace cliquevo::tools::fleet {

namespace {

constexpr std::size_t kTasksAProcess = 8;  // so that the last ones end together
constexpr std::size_t kMostUnits = 25;     // more of them save nothing: starting a program costs no more than one does
constexpr std::int64_t kPollNs = 5'000'000;

// Its output is of no interest; its errors go to our stderr.
Result<pid_t> start(const std::string& line) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  const std::string command = fmt::format("exec {} --watched", line);
  const char* words[] = {"sh", "-c", command.c_str(), nullptr};
  pid_t process = -1;
  const int failed = ::posix_spawnp(&process, "sh", &actions, nullptr, const_cast<char* const*>(words), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (failed == 0) return process;
  return Error{fmt::format("cannot begin a process ({})", std::strerror(failed)), line,
               "see the limits of processes and memory (ulimit -a)"};
}

class Pool {
 public:
  Pool(std::vector<std::string> lines, std::size_t processes, Store& store, ProgressLine& progress)
      : lines_(std::move(lines)), processes_(processes), store_(store), progress_(progress) {}

  Result<void> run() {
    while (next_ < lines_.size() || !running_.empty()) {
      fill();
      if (running_.empty()) break;
      StopOnSignal::sleep_until(monotonic_ns() + kPollNs);
      if (StopOnSignal::received()) return interrupt();
      reap(WNOHANG);
      progress_.update();
    }
    if (stopped_) return *stopped_;
    return {};
  }

 private:
  void fill() {
    while (!stopped_ && running_.size() < processes_ && next_ < lines_.size()) {
      auto process = start(lines_[next_]);
      if (process) {
        running_.push_back(*process);
        ++next_;
      } else if (running_.empty()) {
        stopped_ = process.error();
      } else {
        return;  // when one ends there is room again
      }
    }
  }

  void reap(int how) {
    for (std::size_t k = 0; k < running_.size();) {
      int status = 0;
      if (::waitpid(running_[k], &status, how) == 0) {
        ++k;
        continue;
      }
      running_.erase(running_.begin() + static_cast<std::ptrdiff_t>(k));
      const bool good = WIFEXITED(status) && WEXITSTATUS(status) == 0;
      if (good || stopped_) continue;
      // Units failed, which is no reason to stop; but where the disk takes nothing all others would.
      if (auto room = store_.probe(); !room) stopped_ = room.error();
      if (WIFEXITED(status) && WEXITSTATUS(status) > 125) {
        stopped_ = Error{"cannot run", lines_.front(), "see the program"};
      }
    }
  }

  Result<void> interrupt() {
    for (const pid_t process : running_) ::kill(process, SIGTERM);
    stopped_ = Error{"interrupted", "fleet run", "run again: what is computed is kept"};
    while (!running_.empty()) reap(0);
    return *stopped_;
  }

  std::vector<std::string> lines_;
  std::size_t processes_;
  Store& store_;
  ProgressLine& progress_;
  std::size_t next_ = 0;
  std::vector<pid_t> running_;
  std::optional<Error> stopped_;
};

}  // namespace

Result<void> run_locally(const Plan& plan, const std::string& plan_file, const std::vector<std::size_t>& units,
                         const RunOptions& options, Store& store) {
  const auto processors = std::max<std::size_t>(1, std::thread::hardware_concurrency());
  const std::size_t processes = options.processes > 0 ? static_cast<std::size_t>(options.processes) : processors;
  const std::size_t share = std::clamp<std::size_t>(units.size() / (processes * kTasksAProcess), 1, kMostUnits);
  const std::size_t each = options.units_per_task > 0 ? static_cast<std::size_t>(options.units_per_task) : share;
  const StopOnSignal signals;
  ProgressLine progress(plan, units, store);
  Pool pool(task_lines(plan, plan_file, units, each), processes, store, progress);
  auto done = pool.run();
  progress.finish();
  return done;
}

}  // namespace cliquevo::tools::fleet
