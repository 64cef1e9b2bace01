// SPDX-License-Identifier: BSD-3-Clause
// How --help looks: options with the kind of value they take, texts wrapped beside them, defaults named.
#pragma once

#include <string>

#include <CLI/CLI.hpp>

namespace cliquevo::tools {

class HelpFormat : public CLI::Formatter {
 public:
  HelpFormat();
  std::string make_option_opts(const CLI::Option* option) const override;
  std::string make_option_desc(const CLI::Option* option) const override;
  std::string make_subcommand(const CLI::App* command) const override;
};

// Line breaks instead of blanks, so that no line is longer than `width` (but for words that are).
std::string wrapped(const std::string& text, std::size_t width);

}  // namespace cliquevo::tools
