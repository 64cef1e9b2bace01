// SPDX-License-Identifier: BSD-3-Clause
#include "tools/doctor.h"

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/printable.h"
#include "tools/examination.h"
#include "tools/exit_code.h"

namespace cliquevo::tools {

namespace {

struct DoctorOptions {
  daemon::ConfigArgument config;
  bool json = false;
  bool strict = false;
};

const char* name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::good:
      return "ok";
    case Verdict::advice:
      return "could be better";
    case Verdict::missing:
      break;
  }
  return "MISSING";
}

void print_table(const std::vector<Finding>& findings) {
  std::size_t subject_width = 0;
  for (const Finding& f : findings) subject_width = std::max(subject_width, f.subject.size());
  for (const Finding& f : findings) {
    fmt::print("{:<{}}  {:<15}  {}\n", f.subject, subject_width, name_of(f.verdict), printable(f.found));
    if (f.verdict != Verdict::good) fmt::print("{:<{}}  {:<15}  -> {}\n", "", subject_width, "", printable(f.remedy));
  }
}

void print_json(const std::vector<Finding>& findings) {
  nlohmann::ordered_json out = nlohmann::ordered_json::array();
  for (const Finding& f : findings) {
    const char* verdict = f.verdict == Verdict::good ? "ok" : f.verdict == Verdict::advice ? "advice" : "missing";
    out.push_back({{"subject", f.subject}, {"verdict", verdict}, {"found", f.found}, {"remedy", f.remedy}});
  }
  fmt::print("{}\n", out.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
}

int run(const DoctorOptions& options) {
  const std::vector<Finding> findings = examine(options.config);
  const auto bad = static_cast<std::size_t>(
      std::count_if(findings.begin(), findings.end(), [](const Finding& f) { return f.verdict != Verdict::good; }));
  if (options.json) {
    print_json(findings);
  } else {
    print_table(findings);
    fmt::print("{} of {} ok\n", findings.size() - bad, findings.size());
  }
  return options.strict && bad > 0 ? kNotStrictEnough : kDone;
}

}  // namespace

void add_doctor_command(CliCommand app, int& exit_code) {
  auto options = std::make_shared<DoctorOptions>();
  const CliCommand doctor =
      app.add_subcommand("doctor", "List what a real-time vehicle needs and what this machine has");
  daemon::add_config_options(
      doctor, options->config,
      "Configuration whose LCM URL, source and calibration are looked at (default: as cliquevod)");
  doctor.add_flag("--strict", options->strict, "Exit with 3 unless everything is ok");
  doctor.add_flag("--json", options->json, "Print JSON: subject, verdict (ok, advice, missing), found, remedy");
  doctor.callback([options, &exit_code] { exit_code = run(*options); });
}

}  // namespace cliquevo::tools
