// SPDX-License-Identifier: BSD-3-Clause
// cliquevo-calibrate: what `cliquevo calibrate` runs, with the same command line.
#include <memory>

#include <CLI/CLI.hpp>

#include "core/base/caught.h"
#include "core/base/standard_streams.h"
#include "tools/calibrate/calibrate.h"
#include "tools/exit_code.h"
#include "tools/help_format.h"

namespace {

using namespace cliquevo::tools;

int run(int argc, char** argv) {
  int exit_code = kDone;
  CLI::App app("Calibration of stereo rigs.", "cliquevo");
  app.require_subcommand(1);
  app.formatter(std::make_shared<HelpFormat>());
  add_board_calibration_command(app, exit_code);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& wanted) {
    return app.exit(wanted);
  } catch (const CLI::ParseError& error) {
    return report({"wrong usage", "cliquevo calibrate", error.what() + std::string(" (see cliquevo calibrate --help)")},
                  kWrongUsage);
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
    return report(cliquevo::caught("cliquevo calibrate"));
  }
  if (const auto ok = cliquevo::flush_stdout(); !ok && exit_code == kDone) return report(ok.error());
  return exit_code;
}
