// SPDX-License-Identifier: BSD-3-Clause
// cliquevod: frames in, poses out over LCM, until it is stopped.
#include <string>

#include <CLI/CLI.hpp>

#include "core/base/caught.h"
#include "core/base/standard_streams.h"
#include "daemon/daemon.h"
#include "daemon/log.h"
#include "daemon/pipeline/source.h"

namespace {

using namespace cliquevo::daemon;

int run_line(int argc, char** argv) {
  CLI::App app("Stereo visual odometry as a daemon: grabs stereo pairs and sends poses over LCM.", "cliquevod");
  DaemonOptions options;
  bool check_only = false;
  app.add_option("--config", options.config, "Configuration file (default: the built-in settings)")->type_name("FILE");
  app.add_flag("--check", check_only, "Validate configuration and calibration, print what is in force, and end");
  app.add_option("--trajectory", options.trajectory, "Write the camera's poses here (KITTI format)")->type_name("FILE");
  app.set_version_flag("--version", std::string(CLIQUEVO_VERSION) + " (sources: " + built_in_sources() + ")");
  app.footer(
      "Exit codes: 0 done; 1 bad input or environment; 2 wrong usage.\n"
      "SIGTERM and SIGINT stop it cleanly: frames on their way still go out.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& wanted) {  // --help, --version
    return app.exit(wanted);
  } catch (const CLI::ParseError& error) {
    report({"wrong usage", "cliquevod", std::string(error.what()) + " (see cliquevod --help)"});
    return kWrongUsage;
  }
  return check_only ? check(options) : run(options);
}

}  // namespace

int main(int argc, char** argv) {
  cliquevo::keep_standard_streams();
  int exit_code = kBadInput;
  try {
    exit_code = run_line(argc, argv);
  } catch (...) {  // out of memory, a library at its end
    cliquevo::print_error_line(cliquevo::caught("cliquevod").line());
    return unexpected_end();
  }
  if (const auto ok = cliquevo::flush_stdout(); !ok && exit_code == kDone) {
    cliquevo::print_error_line(ok.error().line());
    return kBadInput;
  }
  return exit_code;
}
