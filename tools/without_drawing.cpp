// SPDX-License-Identifier: BSD-3-Clause
// The program without drawing: what it cannot do, cliquevo-tools does, whose code of everything else is the same.
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <unistd.h>

#include "tools/commands.h"
#include "tools/drawing.h"
#include "tools/exit_code.h"
#include "tools/fleet/run_unit.h"

namespace cliquevo::tools {

namespace {

namespace fs = std::filesystem;

// As built, the programs lie side by side; as installed, bin/cliquevo and libexec/cliquevo/cliquevo-tools.
std::string tools_program() {
  std::error_code unknown;
  const fs::path folder = fs::read_symlink("/proc/self/exe", unknown).parent_path();
  for (const fs::path& path : {folder / "cliquevo-tools", folder / "../libexec/cliquevo/cliquevo-tools"}) {
    if (::access(path.c_str(), X_OK) == 0) return path.lexically_normal();
  }
  return "";
}

// The words of this program's own command line.
std::vector<std::string> command_line() {
  std::ifstream file("/proc/self/cmdline", std::ios::binary);
  const std::string all((std::istreambuf_iterator<char>(file)), {});
  std::vector<std::string> out;
  for (std::size_t begin = 0; begin < all.size();) {
    const std::size_t end = std::min(all.find('\0', begin), all.size());
    out.push_back(all.substr(begin, end - begin));
    begin = end + 1;
  }
  return out;
}

// Returns only when the other program cannot be run.
Error hand_over(const std::string& option) {
  const std::string program = tools_program();
  if (program.empty()) return {"not installed", option, "install the package cliquevo-tools"};
  std::vector<std::string> words = command_line();
  std::vector<char*> arguments;
  arguments.reserve(words.size() + 1);
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  ::execv(program.c_str(), arguments.data());
  return {std::string("cannot run (") + std::strerror(errno) + ")", program,
          "install the package cliquevo-tools again"};
}

CliCommand add_absent_command(CliCommand app, int& exit_code, const std::string& name, const std::string& purpose) {
  const CliCommand command = app.add_subcommand(name, purpose);
  command.pass_on_everything();  // the other program knows the options
  command.callback([name, command, &exit_code] {
    if (!command.has_chosen_subcommand()) exit_code = report(hand_over("cliquevo " + name));
  });
  return command;
}

}  // namespace

Result<const Drawing*> find_drawing(const std::string& option) { return hand_over(option); }

void add_drawing_commands(CliCommand app, int& exit_code, const std::string&) {
  add_absent_command(app, exit_code, "view", kViewPurpose);
  add_absent_command(app, exit_code, "calibrate", kCalibratePurpose);
  // A node computes units without what draws.
  fleet::add_run_unit_command(add_absent_command(app, exit_code, "fleet", fleet::kFleetPurpose), exit_code);
}

}  // namespace cliquevo::tools
