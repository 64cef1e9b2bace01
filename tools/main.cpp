// SPDX-License-Identifier: BSD-3-Clause
// cliquevo: one command for recordings, trajectories and pictures. Linked twice: without and with what draws
// (drawing.h).
#include <memory>
#include <string>

#include <CLI/CLI.hpp>

#include "core/base/caught.h"
#include "core/base/standard_streams.h"
#include "tools/cameras.h"
#include "tools/commands.h"
#include "tools/ctl.h"
#include "tools/doctor.h"
#include "tools/drawing.h"
#include "tools/exit_code.h"
#include "tools/help_format.h"
#include "tools/hil.h"
#include "tools/record.h"
#include "tools/simulate.h"
#include "tools/spy.h"

namespace {

using namespace cliquevo::tools;
using cliquevo::CliCommand;

// The sub-command the line names, for "see ... --help".
std::string command_name(const CLI::App& app) {
  const auto chosen = app.get_subcommands();
  return chosen.empty() ? app.get_name() : app.get_name() + " " + chosen.front()->get_name();
}

int run(int argc, char** argv) {
  int exit_code = kDone;
  CLI::App app("Stereo visual odometry: replay recordings, judge trajectories, render test courses.", "cliquevo");
  app.require_subcommand(1);
  app.set_version_flag("--version", CLIQUEVO_VERSION);
  app.formatter(std::make_shared<HelpFormat>());
  app.footer(
      "Exit codes: 0 done; 1 bad input or environment; 2 wrong usage; 3 asked-for strictness not met.\n"
      "`cliquevo COMMAND --help` lists each command's options, with examples.");
  const CliCommand commands(app);
  add_replay_command(commands, exit_code);
  add_info_command(commands, exit_code);
  add_disparity_command(commands, exit_code);
  add_eval_command(commands, exit_code);
  add_compare_command(commands, exit_code);
  add_drawing_commands(commands, exit_code, CLIQUEVO_VERSION);
  add_simulate_command(commands, exit_code);
  add_cameras_command(commands, exit_code);
  add_record_command(commands, exit_code);
  add_convert_command(commands, exit_code);
#ifdef CLIQUEVO_ARAVIS
  add_hil_command(commands, exit_code);
#endif
  add_mavlink_command(commands, exit_code);
  add_ros2_command(commands, exit_code);
  add_config_command(commands, exit_code);
  add_ctl_command(commands, exit_code);
  add_watch_command(commands, exit_code);
  add_echo_command(commands, exit_code);
  add_doctor_command(commands, exit_code);
  add_spy_command(commands, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& wanted) {  // --help, --version
    return app.exit(wanted);
  } catch (const CLI::ParseError& error) {
    const std::string command = command_name(app);
    const bool unknown = app.get_subcommands().empty() && argc > 1 && argv[1][0] != '-';
    const std::string problem = unknown ? std::string("there is no command '") + argv[1] + "'" : error.what();
    return report({"wrong usage", command, problem + " (see " + command + " --help)"}, kWrongUsage);
  }
  return exit_code;
}

}  // namespace

int main(int argc, char** argv) {
  cliquevo::keep_standard_streams();
  int exit_code = kBadInput;
  try {
    exit_code = run(argc, argv);
  } catch (...) {  // out of memory, a library at its end
    return report(cliquevo::caught("cliquevo"));
  }
  if (const auto ok = cliquevo::flush_stdout(); !ok && exit_code == kDone) return report(ok.error());
  return exit_code;
}
