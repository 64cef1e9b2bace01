// SPDX-License-Identifier: BSD-3-Clause
// cliquevo config: what is written from the table of configuration keys, and from the options.
#include <filesystem>
#include <memory>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "daemon/pipeline/cli_command.h"
#include "daemon/pipeline/command_line.h"
#include "tools/commands.h"
#include "tools/completion.h"
#include "tools/config_pages.h"
#include "tools/exit_code.h"
#include "tools/man_page.h"
#include "tools/output_file.h"

namespace cliquevo::tools {

namespace {

// What the distribution's packages carry, written from the options of both programs.
Result<void> write_pages(CliCommand app, const std::string& version, const std::string& folder) {
  const CompletionWords words{{describe_app(app), describe_daemon(version)}, config_settings()};
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  const std::pair<const char*, std::string> files[] = {{"cliquevo.1", man_page(words.programs[0], 1, version)},
                                                       {"cliquevod.8", man_page(words.programs[1], 8, version)},
                                                       {"cliquevo.bash", bash_completion(words)},
                                                       {"_cliquevo", zsh_completion(words)},
                                                       {"cliquevo.fish", fish_completion(words)}};
  for (const auto& [name, text] : files) {
    auto file = OutputFile::open(folder + "/" + name, "page");
    if (!file) return file.error();
    if (auto ok = file->write(text); !ok) return ok;
  }
  return {};
}

}  // namespace

void add_config_command(CliCommand app, int& exit_code) {
  const CliCommand config =
      app.add_subcommand("config", "Print a sample configuration, the page on it, a schema, or what is checked");
  auto what = std::make_shared<std::string>("sample");
  auto folder = std::make_shared<std::string>();
  config
      .add_option(
          "WHAT", *what,
          "sample (every key with its default), page, schema, checks (of the odometry, as JSON); pages: man pages "
          "and shell completion, written to --out")
      .one_of({"sample", "page", "schema", "checks", "pages"});
  config.add_option("--out", *folder, "Folder for `pages`").type_name("DIR");
  config.footer(
      "Examples:\n"
      "  cliquevo config sample > rig.yaml\n"
      "  cliquevo config pages --out pages && source pages/cliquevo.bash && man -l pages/cliquevo.1");
  config.callback([app, what, folder, &exit_code] {
    if ((*what == "pages") != !folder->empty()) {
      exit_code = report({"wrong usage", "config", "give --out DIR with pages, and with nothing else"}, kWrongUsage);
      return;
    }
    if (*what == "pages") {
      const auto written = write_pages(app, CLIQUEVO_VERSION, *folder);
      exit_code = written ? kDone : report(written.error());
      return;
    }
    fmt::print("{}", *what == "page"     ? config_page()
                     : *what == "schema" ? config_schema()
                     : *what == "checks" ? check_list()
                                         : config_sample());
    exit_code = kDone;
  });
}

}  // namespace cliquevo::tools
