// SPDX-License-Identifier: BSD-3-Clause
#include "tools/man_page.h"

#include <algorithm>
#include <cctype>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace cliquevo::tools {

namespace {

// Text as roff takes it: no request, no escape of its own.
std::string roff(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    const bool line_begins = i == 0 || text[i - 1] == '\n';
    if (line_begins && (c == '.' || c == '\'')) out += "\\&";
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else if (c == '\'') {
      out += "\\(aq";
    } else if (c == '`') {
      out += "\\(ga";
    } else {
      out += c;
    }
  }
  return out;
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::toupper(c); });
  return text;
}

std::string synopsis(const CommandInfo& command) {
  std::string out = fmt::format(".B {}\n", roff(command.path));
  const auto named = [](const OptionInfo& option) { return !option.positional; };
  if (std::any_of(command.options.begin(), command.options.end(), named)) out += "[\\fIOPTIONS\\fR]\n";
  for (const OptionInfo& option : command.options) {
    if (!option.positional) continue;
    const std::string name = fmt::format("\\fI{}\\fR", roff(option.name));
    out += option.required ? name + "\n" : "[" + name + "]\n";
  }
  if (!command.commands.empty()) out += "\\fICOMMAND\\fR ...\n";
  return out;
}

std::string options(const CommandInfo& command) {
  std::string out;
  for (const OptionInfo& option : command.options) {
    std::string head =
        option.positional ? fmt::format("\\fI{}\\fR", roff(option.name)) : fmt::format("\\fB{}\\fR", roff(option.name));
    if (!option.positional && !option.value.empty()) head += fmt::format(" \\fI{}\\fR", roff(option.value));
    std::string text = option.meaning;
    if (!option.choices.empty() && text.find(option.choices.back()) == std::string::npos) {
      text += fmt::format(" ({})", fmt::join(option.choices, ", "));
    }
    if (option.required && !option.positional) text += " (required)";
    if (!option.standard.empty()) text += fmt::format(" (default {})", option.standard);
    out += fmt::format(".TP\n{}\n{}\n", head, roff(text.empty() ? "-" : text));
  }
  return out;
}

std::string footer(const CommandInfo& command) {
  return command.footer.empty() ? "" : fmt::format(".PP\n.nf\n{}\n.fi\n", roff(command.footer));
}

}  // namespace

std::string man_page(const CommandInfo& program, int section, const std::string& version) {
  const std::string name = program.name();
  std::string out = fmt::format(
      ".\\\" Written by `cliquevo config pages` from the program's options.\n"
      ".TH {} {} \"\" \"cliquevo {}\" \"{}\"\n.SH NAME\n{} \\- {}\n.SH SYNOPSIS\n{}",
      upper(name), section, version, section == 8 ? "System administration" : "User commands", name,
      roff(program.purpose), synopsis(program));
  out += ".SH OPTIONS\n" + options(program) + footer(program);
  const auto all = flattened(program);
  if (all.size() > 1) out += ".SH COMMANDS\n";
  for (auto command = all.begin() + 1; command < all.end(); ++command) {
    out += fmt::format(".SS {}\n{}.PP\n{}.\n{}{}", roff((*command)->path), synopsis(**command),
                       roff((*command)->purpose), options(**command), footer(**command));
  }
  out += fmt::format(
      ".SH FILES\n.TP\n.I /etc/cliquevo/cliquevo.yaml\nThe daemon\\(aqs configuration; {} prints one with every key "
      "and "
      "its meaning.\n.SH SEE ALSO\n.BR {}\n",
      "\\fBcliquevo config sample\\fR", section == 8 ? "cliquevo (1)" : "cliquevod (8)");
  return out;
}

}  // namespace cliquevo::tools
