// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/cli_command.h"

#include <optional>

#include <CLI/CLI.hpp>

namespace cliquevo {

CliOption CliOption::type_name(const std::string& name) const {
  option_->type_name(name);
  return *this;
}

CliOption CliOption::required() const {
  option_->required();
  return *this;
}

CliOption CliOption::excludes(CliOption other) const {
  option_->excludes(other.option_);
  return *this;
}

CliOption CliOption::capture_default_str() const {
  option_->capture_default_str();
  return *this;
}

CliOption CliOption::optional_value(const std::string& left_out) const {
  option_->expected(0, 1)->default_str(left_out);
  return *this;
}

CliOption CliOption::repeatable() const {
  option_->expected(1)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  return *this;
}

CliOption CliOption::one_value_each_time() const {
  option_->allow_extra_args(false);
  return *this;
}

CliOption CliOption::delimiter(char between) const {
  option_->delimiter(between);
  return *this;
}

CliOption CliOption::between(double least, double most) const {
  option_->check(CLI::Range(least, most));
  return *this;
}

CliOption CliOption::between(int least, int most) const {
  option_->check(CLI::Range(least, most));
  return *this;
}

CliOption CliOption::between(std::int64_t least, std::int64_t most) const {
  option_->check(CLI::Range(least, most));
  return *this;
}

CliOption CliOption::positive() const {
  option_->check(CLI::PositiveNumber);
  return *this;
}

CliOption CliOption::not_negative() const {
  option_->check(CLI::NonNegativeNumber);
  return *this;
}

CliOption CliOption::one_of(const std::vector<std::string>& names) const {
  option_->check(CLI::IsMember(names));
  return *this;
}

CliOption CliOption::checked_by(const std::function<std::string(const std::string&)>& problem) const {
  option_->check(CLI::Validator([problem](const std::string& text) { return problem(text); }, ""));
  return *this;
}

CliCommand CliCommand::add_subcommand(const std::string& name, const std::string& purpose) const {
  return CliCommand(*app_->add_subcommand(name, purpose));
}

template <typename T>
CliOption CliCommand::add_option(const std::string& names, T& target, const std::string& meaning) const {
  return CliOption(*app_->add_option(names, target, meaning));
}

template CliOption CliCommand::add_option(const std::string&, std::string&, const std::string&) const;
template CliOption CliCommand::add_option(const std::string&, int&, const std::string&) const;
template CliOption CliCommand::add_option(const std::string&, std::uint16_t&, const std::string&) const;
template CliOption CliCommand::add_option(const std::string&, std::int64_t&, const std::string&) const;
template CliOption CliCommand::add_option(const std::string&, double&, const std::string&) const;
template CliOption CliCommand::add_option(const std::string&, std::optional<std::string>&, const std::string&) const;
template CliOption CliCommand::add_option(const std::string&, std::optional<int>&, const std::string&) const;
template CliOption CliCommand::add_option(const std::string&, std::optional<std::int64_t>&, const std::string&) const;
template CliOption CliCommand::add_option(const std::string&, std::optional<double>&, const std::string&) const;
template CliOption CliCommand::add_option(const std::string&, std::vector<std::string>&, const std::string&) const;
template CliOption CliCommand::add_option(const std::string&, std::vector<double>&, const std::string&) const;

template <typename T>
CliOption CliCommand::add_option_function(const std::string& names, const std::function<void(const T&)>& take,
                                          const std::string& meaning) const {
  return CliOption(*app_->add_option_function<T>(names, take, meaning));
}

template CliOption CliCommand::add_option_function<std::string>(const std::string&,
                                                                const std::function<void(const std::string&)>&,
                                                                const std::string&) const;
template CliOption CliCommand::add_option_function<std::int64_t>(const std::string&,
                                                                 const std::function<void(const std::int64_t&)>&,
                                                                 const std::string&) const;
template CliOption CliCommand::add_option_function<double>(const std::string&,
                                                           const std::function<void(const double&)>&,
                                                           const std::string&) const;

CliOption CliCommand::add_flag(const std::string& names, bool& target, const std::string& meaning) const {
  return CliOption(*app_->add_flag(names, target, meaning));
}

CliOption CliCommand::get_option(const std::string& name) const { return CliOption(*app_->get_option(name)); }

CliCommand CliCommand::footer(const std::string& text) const {
  app_->footer(text);
  return *this;
}

CliCommand CliCommand::callback(const std::function<void()>& run) const {
  app_->callback(run);
  return *this;
}

CliCommand CliCommand::require_subcommand(int least, int most) const {
  app_->require_subcommand(static_cast<std::size_t>(least), static_cast<std::size_t>(most));
  return *this;
}

CliCommand CliCommand::require_subcommand() const {
  app_->require_subcommand(1);
  return *this;
}

CliCommand CliCommand::fallthrough() const {
  app_->fallthrough();
  return *this;
}

bool CliCommand::has_chosen_subcommand() const { return !app_->get_subcommands().empty(); }

CliCommand CliCommand::pass_on_everything() const {
  app_->prefix_command();
  app_->set_help_flag();
  return *this;
}

CliCommand CliCommand::pass_on_nothing() const {
  app_->prefix_command(false);
  app_->set_help_flag("-h,--help", "Print this help message and exit");
  return *this;
}

std::vector<std::string> CliCommand::passed_on() const { return app_->remaining(); }

void refuse_value(const std::string& option, const std::string& problem) {
  throw CLI::ValidationError(option, problem);
}

bool read_number(const std::string& text, double& value) { return CLI::detail::lexical_cast(text, value); }

}  // namespace cliquevo
