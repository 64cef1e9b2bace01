// SPDX-License-Identifier: BSD-3-Clause
// Options and sub-commands of a command line, each as CLI11 has it. CLI11's own header takes a compiler seven seconds
// in every file that includes it; this one takes none.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace CLI {  // NOLINT(readability-identifier-naming): as CLI11 has it
class App;
class Option;
}  // namespace CLI

namespace cliquevo {

// A handle: copies are the same option. Each function returns it, so that calls can be chained.
class CliOption {
 public:
  explicit CliOption(CLI::Option& option) : option_(&option) {}

  // What the help calls the value: FILE, HZ.
  CliOption type_name(const std::string& name) const;
  CliOption required() const;
  CliOption excludes(CliOption other) const;

  // The help names the value that the variable has now.
  CliOption capture_default_str() const;
  // The value may be left out, and is this one then.
  CliOption optional_value(const std::string& left_out) const;
  // May be given again, with one value each time; all count.
  CliOption repeatable() const;
  // The same, in a help that shows that the option takes several.
  CliOption one_value_each_time() const;
  // Values in one word, with this between.
  CliOption delimiter(char between) const;

  // What is accepted; anything else is wrong usage.
  CliOption between(double least, double most) const;
  CliOption between(int least, int most) const;
  CliOption between(std::int64_t least, std::int64_t most) const;
  CliOption positive() const;
  CliOption not_negative() const;
  CliOption one_of(const std::vector<std::string>& names) const;
  // `problem` says what is wrong with a value, in words; nothing where it can be taken.
  CliOption checked_by(const std::function<std::string(const std::string&)>& problem) const;

 private:
  CLI::Option* option_;
};

// A handle too: a program's command line, or a sub-command's.
class CliCommand {
 public:
  explicit CliCommand(CLI::App& app) : app_(&app) {}

  CLI::App& app() const { return *app_; }

  CliCommand add_subcommand(const std::string& name, const std::string& purpose) const;
  // The value goes into `target`, which must live until the line is parsed. Names: "--rate", "-j,--jobs"; "SOURCE" is a
  // positional. For strings, numbers, optional numbers and lists of strings or numbers.
  template <typename T>
  CliOption add_option(const std::string& names, T& target, const std::string& meaning) const;
  // The value goes into a function; for strings, std::int64_t and double.
  template <typename T>
  CliOption add_option_function(const std::string& names, const std::function<void(const T&)>& take,
                                const std::string& meaning) const;
  CliOption add_flag(const std::string& names, bool& target, const std::string& meaning) const;
  // Of a name that was added before.
  CliOption get_option(const std::string& name) const;

  CliCommand footer(const std::string& text) const;
  // Runs when the line has been parsed and names this sub-command.
  CliCommand callback(const std::function<void()>& run) const;
  CliCommand require_subcommand(int least, int most) const;
  CliCommand require_subcommand() const;
  // Options of the command above may come behind this one's name.
  CliCommand fallthrough() const;

  // Whether the parsed line names a sub-command of this one.
  bool has_chosen_subcommand() const;

  // Everything behind the name is another program's business, --help too.
  CliCommand pass_on_everything() const;
  // For a sub-command of such a one.
  CliCommand pass_on_nothing() const;
  std::vector<std::string> passed_on() const;

 private:
  CLI::App* app_;
};

// From a function that takes an option's value: it is wrong usage.
[[noreturn]] void refuse_value(const std::string& option, const std::string& problem);

// The number that a word of the command line is, if it is one.
bool read_number(const std::string& text, double& value);

}  // namespace cliquevo
