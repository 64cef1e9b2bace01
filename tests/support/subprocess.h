// SPDX-License-Identifier: BSD-3-Clause
// Runs the project's programs as a user would: real processes, their output and exit code.
#pragma once

#include <string>
#include <sys/types.h>
#include <utility>
#include <vector>

namespace cliquevo::test {

struct Finished {
  int exit_code = -1;  // 128 + signal when one ended it
  std::string out;
  std::string err;
};

using Environment = std::vector<std::pair<std::string, std::string>>;  // added to the caller's

// A running program; killed when it is still running at the end of this object.
class Subprocess {
 public:
  // command[0] is looked up in PATH unless it has a slash.
  explicit Subprocess(const std::vector<std::string>& command, const Environment& environment = {});
  ~Subprocess();
  Subprocess(const Subprocess&) = delete;
  Subprocess& operator=(const Subprocess&) = delete;

  pid_t pid() const { return pid_; }
  void send(int signal) const;
  // What it has printed so far.
  std::string printed() const;
  // Waits for its end; kills it after timeout_s, which shows as exit code 137.
  Finished wait(double timeout_s = 240.0);

 private:
  std::string folder_;
  pid_t pid_ = -1;
};

Finished run(const std::vector<std::string>& command, const Environment& environment = {});

// The whole file; empty when there is none.
std::string read_file(const std::string& path);
std::vector<std::string> lines_of(const std::string& text);

}  // namespace cliquevo::test
