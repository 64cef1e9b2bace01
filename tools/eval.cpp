// SPDX-License-Identifier: BSD-3-Clause
// cliquevo eval: how good is a trajectory?
#include <filesystem>
#include <memory>
#include <string>

#include <fmt/format.h>

#include "tools/commands.h"
#include "tools/drawing.h"
#include "tools/evaluation.h"
#include "tools/evaluation_json.h"
#include "tools/exit_code.h"
#include "tools/output_file.h"
#include "tools/reference.h"

namespace cliquevo::tools {

namespace {

struct EvalArguments {
  std::string reference;
  std::string estimate;
  EvaluationOptions options;
  double tolerance_s = 0.01;
  bool body_frame = false;
  bool frame_is_stated = false;
  bool json = false;
  std::string plot;
  std::string report;
};

double percent_of(double value, double reference) { return reference > 0.0 ? 100.0 * value / reference : 0.0; }

void print_table(const Evaluation& e) {
  fmt::print("frames       {} compared (reference {}, estimate {})\n", e.frames_compared, e.frames_reference,
             e.frames_estimate);
  fmt::print("path         {:.3f} m, reference {:.3f} m ({:+.2f} %)\n", e.path_estimate_m, e.path_m,
             percent_of(e.path_estimate_m - e.path_m, e.path_m));
  if (e.sampled_path_m) {
    fmt::print("  sampled    {:.3f} m, reference {:.3f} m ({:+.2f} %)\n", *e.sampled_path_estimate_m, *e.sampled_path_m,
               percent_of(*e.sampled_path_estimate_m - *e.sampled_path_m, *e.sampled_path_m));
  }
  if (e.t_err_pct) {
    fmt::print("segments     {:.4f} %   {:.6f} deg/m   ({} segments)\n", *e.t_err_pct, *e.r_err_deg_m, e.segments);
    for (const LengthError& entry : e.by_length) {
      if (entry.segments == 0) {
        fmt::print("  {:7g} m  the path is too short\n", entry.length_m);
      } else {
        fmt::print("  {:7g} m  {:.4f} %   {:.6f} deg/m   ({})\n", entry.length_m, entry.t_err_pct, entry.r_err_deg_m,
                   entry.segments);
      }
    }
  } else {
    fmt::print("segments     none: the path is shorter than every length\n");
  }
  fmt::print("ATE          {:.4f} m RMS, {:.4f} m at most (after rigid alignment)\n", e.ate_m, e.ate_max_m);
  fmt::print("RPE          {:.4f} cm   {:.5f} deg (RMS, frame to frame)\n", 100.0 * e.rpe_m, e.rpe_deg);
  fmt::print("end          {:.4f} m   {:.4f} deg", e.end_m, e.end_deg);
  if (e.end_pct) fmt::print("   {:.4f} % of the way", *e.end_pct);
  fmt::print("\n");
}

// Camera motions against body motions (or the other way round) leave positions comparable and little else.
void warn_of_other_axes(const EvalArguments& arguments, const daemon::Trajectory& reference,
                        const daemon::Trajectory& estimate, EvaluationOptions options, const Evaluation& result) {
  options.reference_frame = arguments.body_frame ? ReferenceFrame::camera : ReferenceFrame::body;
  const auto turned = associate(reference, estimate, options);
  if (!turned || result.rpe_m < 3.0 * evaluate(*turned, options).rpe_m + 1e-9) return;
  warn(
      {"the reference seems to be in other axes than said", arguments.reference,
       fmt::format("only the ATE can be trusted; try --reference-frame {}", arguments.body_frame ? "camera" : "body")});
}

Result<void> draw(OutputFile& file, const EvalArguments& arguments, const daemon::Trajectory& estimate,
                  const std::vector<PosePair>& pairs, const Drawing& drawing) {
  RunPicture picture;
  picture.title = std::filesystem::path(arguments.estimate).filename().string();
  for (const daemon::StampedPose& pose : estimate.poses) picture.trajectory.push_back(pose.T_world_camera);
  picture.pairs = pairs;
  picture.align = estimate.format == daemon::TrajectoryFormat::tum;
  const auto format = plot_format(arguments.plot);
  const auto png = format ? drawing.plot(picture, *format) : format.error();
  return png ? file.write(*png) : png.error();
}

int run_eval(const EvalArguments& arguments) {
  if (auto format = plot_format(arguments.plot); !format) return report(format.error(), kWrongUsage);
  const Drawing* drawing = nullptr;
  if (!arguments.plot.empty() || !arguments.report.empty()) {
    auto found = find_drawing(arguments.plot.empty() ? "eval --report" : "eval --plot");
    if (!found) return report(found.error());
    drawing = *found;
  }
  const auto compared = read_compared(arguments.reference, arguments.estimate, arguments.frame_is_stated);
  if (!compared) return report(compared.error());
  const daemon::Trajectory* reference = &compared->reference;
  const daemon::Trajectory* estimate = &compared->estimate;
  EvaluationOptions options = arguments.options;
  options.max_stamp_difference_ns = static_cast<std::int64_t>(arguments.tolerance_s * 1e9);
  options.reference_frame = arguments.body_frame ? ReferenceFrame::body : ReferenceFrame::camera;
  const auto pairs = associate(*reference, *estimate, options);
  if (!pairs) return report(pairs.error());

  Evaluation result = evaluate(*pairs, options);
  result.frames_reference = reference->poses.size();
  result.frames_estimate = estimate->poses.size();
  if (arguments.json) {
    fmt::print("{}\n", evaluation_json(result));
  } else {
    print_table(result);
  }
  for (const Error& warning : compared->warnings) warn(warning);
  warn_of_other_axes(arguments, *reference, *estimate, options, result);
  if (!arguments.plot.empty()) {
    auto file = OutputFile::open(arguments.plot, "plot");
    if (!file) return report(file.error());
    if (auto drawn = draw(*file, arguments, *estimate, *pairs, *drawing); !drawn) return report(drawn.error());
  }
  if (!arguments.report.empty()) {
    auto file = OutputFile::open(arguments.report, "report");
    if (!file) return report(file.error());
    const std::string page = drawing->evaluation_report(std::filesystem::path(arguments.estimate).filename().string(),
                                                        to_json(result), *estimate, *pairs);
    if (auto written = file->write(page); !written) return report(written.error());
  }
  return kDone;
}

// nan is above nothing and below nothing: so test for what is allowed, not for what is not.
std::function<std::string(const std::string&)> in_range(double least, double most, bool (*taken)(double, double),
                                                        const std::string& what) {
  return [=](const std::string& text) {
    double value = 0.0;
    const bool number = read_number(text, value);
    return number && taken(value, least) && value <= most ? std::string() : "'" + text + "' is not " + what;
  };
}

}  // namespace

void add_eval_command(CliCommand app, int& exit_code) {
  const auto is_length = in_range(
      0.0, 1e9, [](double value, double least) { return value > least; }, "a length in m");
  const auto is_tolerance = in_range(
      0.0, 1e6, [](double value, double least) { return value >= least; }, "a time from 0 to 1000000 s");
  auto arguments = std::make_shared<EvalArguments>();
  const CliCommand eval =
      app.add_subcommand("eval", "Compare a trajectory with its reference: segment errors, ATE, RPE, drift");
  eval.add_option(
          "--reference,REFERENCE", arguments->reference,
          "Trajectory held to be true (KITTI or TUM format, EuRoC's data.csv, KITTI-360's cam0_to_world.txt, a table "
          "whose heading names its columns, ...: docs/inputs-and-outputs.md)")
      .required()
      .type_name("FILE");
  eval.add_option("--estimate,ESTIMATE", arguments->estimate,
                  "Trajectory to judge, of the same formats (without stamps beside without, with stamps beside with)")
      .required()
      .type_name("FILE");
  eval.add_option("--lengths", arguments->options.lengths_m, "Lengths of the segments, m, with commas between")
      .delimiter(',')
      .checked_by(is_length)
      .capture_default_str()
      .type_name("L,L,...");
  eval.add_option("--tolerance", arguments->tolerance_s, "Poses this close in time belong together, s (TUM)")
      .checked_by(is_tolerance)
      .capture_default_str()
      .type_name("S");
  eval.add_option("--sample-period", arguments->options.sample_period_s,
                  "Also compare the lengths of both paths over poses this far apart, s (TUM): jitter adds up otherwise")
      .checked_by(is_length)
      .type_name("S");
  eval.add_option_function<std::string>(
          "--reference-frame",
          [arguments](const std::string& frame) {
            arguments->body_frame = frame == "body";
            arguments->frame_is_stated = true;
          },
          "Axes of the reference's poses: camera (Z forward, Y down) or body (X forward, Z up); default camera, and "
          "for "
          "poses of a body none: say it")
      .one_of({"camera", "body"})
      .type_name("FRAME");
  eval.add_flag("--json", arguments->json, "Print JSON instead of the table");
  eval.add_option("--plot", arguments->plot,
                  "Draw both trajectories and the error over distance: PNG, SVG or PDF by ending")
      .type_name("FILE.png|svg|pdf");
  eval.add_option("--report", arguments->report, "Write a page with map, errors and tables into one file")
      .type_name("FILE.html");
  eval.footer(
      "KITTI files are compared line by line, TUM files by nearest stamp. Segment errors are means over segments of\n"
      "each length from every start frame; the ATE is taken after a rigid alignment without scale.\n"
      "Examples:\n"
      "  cliquevo eval poses.txt trajectory.txt --lengths 5,10,20,40\n"
      "  cliquevo eval --reference groundtruth.tum --estimate trajectory.tum --json");
  eval.callback([arguments, &exit_code] { exit_code = run_eval(*arguments); });
}

}  // namespace cliquevo::tools
