// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/calibrate.h"
#include "tools/commands.h"
#include "tools/drawing.h"
#include "tools/exit_code.h"
#include "tools/fleet/fleet.h"
#include "tools/report.h"

namespace cliquevo::tools {

namespace {

class AlbumReport : public RunReport {
 public:
  void add(const daemon::FramePipeline& pipeline, const drivers::StereoPair& pair) override {
    album_.add(pipeline, pair);
  }
  std::string page(const RunTexts& texts, const RunLog& log,
                   const std::optional<RunReference>& reference) const override {
    return tools::run_report(texts, log, reference, album_);
  }

 private:
  view::Album album_;
};

class OwnDrawing : public Drawing {
 public:
  Result<std::vector<unsigned char>> plot(const RunPicture& run, PictureFormat format) const override {
    return draw_plot(run, format);
  }
  std::unique_ptr<RunReport> run_report() const override { return std::make_unique<AlbumReport>(); }
  std::string evaluation_report(const std::string& title, const nlohmann::json& result,
                                const daemon::Trajectory& estimate, const std::vector<PosePair>& pairs) const override {
    return tools::evaluation_report(title, result, estimate, pairs);
  }
  std::string comparison_report(const std::string& title, const nlohmann::json& comparison) const override {
    return tools::comparison_report(title, comparison);
  }
};

}  // namespace

Result<const Drawing*> find_drawing(const std::string&) {
  static const OwnDrawing drawing;
  return &drawing;
}

void add_drawing_commands(CliCommand app, int& exit_code, const std::string& version) {
  add_view_command(app, exit_code, version);
  fleet::add_fleet_command(app, exit_code);
#ifdef CLIQUEVO_CALIBRATE
  add_board_calibration_command(app, exit_code, version);
#else
  app.add_subcommand("calibrate", kCalibratePurpose).pass_on_everything().callback([&exit_code] {
    exit_code = report({"not in this build", "cliquevo calibrate",
                        "it needs OpenCV and the AprilTag library: run tools/setup, then build again"});
  });
#endif
}

}  // namespace cliquevo::tools
