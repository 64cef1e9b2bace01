// SPDX-License-Identifier: BSD-3-Clause
#include "tools/doctor.h"

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include "core/base/printable.h"
#include "tools/examination.h"
#include "tools/exit_code.h"

namespace cliquevo::tools {

namespace {

struct DoctorOptions {
  std::string config;
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

}  // namespace

void add_doctor_command(CLI::App& app, int& exit_code) {
  auto options = std::make_shared<DoctorOptions>();
  CLI::App* doctor = app.add_subcommand("doctor", "Tell what a real-time vehicle needs and what this machine has");
  doctor->add_option("--config", options->config, "Configuration whose LCM URL, source and calibration are looked at")
      ->type_name("FILE");
  doctor->add_flag("--strict", options->strict, "Exit with 3 unless everything is ok");
  doctor->callback([options, &exit_code] {
    const std::vector<Finding> findings = examine(options->config);
    print_table(findings);
    const auto bad =
        std::count_if(findings.begin(), findings.end(), [](const Finding& f) { return f.verdict != Verdict::good; });
    fmt::print("{} of {} ok\n", findings.size() - static_cast<std::size_t>(bad), findings.size());
    if (options->strict && bad > 0) exit_code = kNotStrictEnough;
  });
}

}  // namespace cliquevo::tools
