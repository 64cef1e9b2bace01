// SPDX-License-Identifier: BSD-3-Clause
// What plots and pages are drawn with. The program `cliquevo-tools` has it; `cliquevo`, which a vehicle runs, has not,
// and hands a command line that needs it over. Which one a program gets is decided when it is linked: with_drawing.cpp
// or without_drawing.cpp.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "core/base/result.h"
#include "daemon/pipeline/cli_command.h"
#include "daemon/pipeline/trajectory_file.h"
#include "tools/plot.h"
#include "tools/run_log.h"

namespace cliquevo::tools {

struct RunTexts {
  std::string title;
  std::string summary;        // as printed
  std::string stats_json;     // as --stats writes it
  std::string configuration;  // in force
  StereoModel model;
};

// A page about a run, collected frame by frame.
class RunReport {
 public:
  virtual ~RunReport() = default;
  virtual void add(const daemon::FramePipeline& pipeline, const drivers::StereoPair& pair) = 0;
  virtual std::string page(const RunTexts& texts, const RunLog& log,
                           const std::optional<RunReference>& reference) const = 0;
};

class Drawing {
 public:
  virtual ~Drawing() = default;
  virtual Result<std::vector<unsigned char>> plot(const RunPicture& run, PictureFormat format) const = 0;
  virtual std::unique_ptr<RunReport> run_report() const = 0;
  // result: as `eval --json` prints it.
  virtual std::string evaluation_report(const std::string& title, const nlohmann::json& result,
                                        const daemon::Trajectory& estimate,
                                        const std::vector<PosePair>& pairs) const = 0;
  // comparison: as `compare --json` prints it.
  virtual std::string comparison_report(const std::string& title, const nlohmann::json& comparison) const = 0;
};

// The drawing, for an option ("--plot") that needs it. A program without one runs cliquevo-tools on the same command
// line and returns only when that cannot be run, with the reason.
Result<const Drawing*> find_drawing(const std::string& option);
// Sub-commands of which nothing is left without drawing; in a program without it they are handed over.
void add_drawing_commands(CliCommand app, int& exit_code, const std::string& version);

}  // namespace cliquevo::tools
