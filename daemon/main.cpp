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
  CLI::App app(kDaemonPurpose, "cliquevod");
  DaemonOptions options;
  add_daemon_options(cliquevo::CliCommand(app), options);
  app.set_version_flag("--version", std::string(CLIQUEVO_VERSION) + " (sources: " + built_in_sources() + ")");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& wanted) {  // --help, --version
    return app.exit(wanted);
  } catch (const CLI::ParseError& error) {
    report({"wrong usage", "cliquevod", std::string(error.what()) + " (see cliquevod --help)"});
    return kWrongUsage;
  }
  return options.check ? check(options) : run(options);
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
