// SPDX-License-Identifier: BSD-3-Clause
#include "tools/help_format.h"

#include <sstream>

namespace cliquevo::tools {

namespace {

constexpr std::size_t kColumn = 26;  // where texts begin
constexpr std::size_t kTextWidth = 100 - kColumn;

}  // namespace

std::string wrapped(const std::string& text, std::size_t width) {
  std::istringstream words(text);
  std::string out;
  std::size_t line = 0;
  for (std::string word; words >> word;) {
    if (line > 0 && line + 1 + word.size() > width) {
      out += '\n';
      line = 0;
    }
    if (line > 0) {
      out += ' ';
      ++line;
    }
    out += word;
    line += word.size();
  }
  return out;
}

HelpFormat::HelpFormat() { column_width(kColumn); }

std::string HelpFormat::make_option_opts(const CLI::Option* option) const {
  if (option->get_type_size() == 0 || option->get_positional()) return "";
  // Checks add what they accept to the type's name, behind a colon.
  const std::string type = option->get_type_name();
  return " " + type.substr(0, type.find(':'));
}

std::string HelpFormat::make_option_desc(const CLI::Option* option) const {
  std::string text = option->get_description();
  std::string standard = option->get_default_str();
  std::erase(standard, '[');
  std::erase(standard, ']');
  if (option->get_required() && !option->get_positional()) text += " (required)";
  // Where the value may be left out, CLI11 keeps here what the bare option means: no default.
  if (!standard.empty() && option->get_expected_min() > 0) text += " (default " + standard + ")";
  return wrapped(text, kTextWidth);
}

std::string HelpFormat::make_subcommand(const CLI::App* command) const {
  std::ostringstream out;
  CLI::detail::format_help(out, command->get_name(), wrapped(command->get_description(), kTextWidth), kColumn);
  return out.str();
}

}  // namespace cliquevo::tools
