// SPDX-License-Identifier: BSD-3-Clause
// cliquevo config: what is written from the table of configuration keys.
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include "tools/commands.h"
#include "tools/config_pages.h"
#include "tools/exit_code.h"

namespace cliquevo::tools {

void add_config_command(CLI::App& app, int& exit_code) {
  CLI::App* config = app.add_subcommand("config", "Print a sample configuration, the page on it, or a schema");
  auto what = std::make_shared<std::string>("sample");
  config->add_option("WHAT", *what, "sample (every key with its default), page, schema, or completion (bash)")
      ->check(CLI::IsMember({"sample", "page", "schema", "completion"}));
  config->footer("Example: cliquevo config sample > rig.yaml");
  config->callback([what, &exit_code] {
    fmt::print("{}", *what == "page"         ? config_page()
                     : *what == "schema"     ? config_schema()
                     : *what == "completion" ? config_completion()
                                             : config_sample());
    exit_code = kDone;
  });
}

}  // namespace cliquevo::tools
