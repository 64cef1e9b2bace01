// SPDX-License-Identifier: BSD-3-Clause
// `cliquevo calibrate` is a program of its own, cliquevo-calibrate, since it needs OpenCV, which no vehicle needs.
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <unistd.h>
#include <vector>

#include "tools/commands.h"
#include "tools/exit_code.h"

namespace cliquevo::tools {

namespace {

namespace fs = std::filesystem;

// Beside this program, as built.
std::string calibrating_program() {
  std::error_code unknown;
  const fs::path program = fs::read_symlink("/proc/self/exe", unknown).parent_path() / "cliquevo-calibrate";
  return ::access(program.c_str(), X_OK) == 0 ? program.string() : "";
}

// Returns only when the other program cannot be run.
int hand_over(std::vector<std::string> words) {
  const std::string program = calibrating_program();
  if (program.empty()) {
    return report({"not installed", "cliquevo-calibrate",
                   "build it from the sources, with libopencv-dev and libapriltag-dev: it lies beside cliquevo then"});
  }
  words.insert(words.begin(), {program, "calibrate"});
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  ::execv(program.c_str(), arguments.data());
  return report({"cannot run", program, std::strerror(errno)});
}

}  // namespace

void add_calibrate_command(CLI::App& app, int& exit_code) {
  CLI::App* command = app.add_subcommand("calibrate", kCalibratePurpose);
  command->prefix_command();
  command->set_help_flag();  // the other program knows the options
  command->callback([command, &exit_code] { exit_code = hand_over(command->remaining()); });
}

}  // namespace cliquevo::tools
