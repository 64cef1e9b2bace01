// SPDX-License-Identifier: BSD-3-Clause
#include "tools/run_log.h"

#include <algorithm>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace cliquevo::tools {

namespace {

using nlohmann::json;
using vo::Status;

constexpr double kNsPerMs = 1e6;
constexpr double kDegreesOfARadian = 57.295779513082320877;

// The stages of a frame, in the order in which it passes them.
struct Stage {
  const char* name;
  std::int64_t (*time_ns)(const FrameRecord&);
};
constexpr Stage kStages[] = {
    {"read", [](const FrameRecord& f) { return f.read_ns; }},
    {"rectify", [](const FrameRecord& f) { return f.times.rectify_ns; }},
    {"stereo", [](const FrameRecord& f) { return f.times.stereo_ns; }},
    {"odometry", [](const FrameRecord& f) { return f.times.odometry_ns; }},
    {"total", [](const FrameRecord& f) { return f.total_ns(); }},
};
constexpr Stage kSteps[] = {
    {"features", [](const FrameRecord& f) { return f.estimate.times.features_ns; }},
    {"scores", [](const FrameRecord& f) { return f.estimate.times.scores_ns; }},
    {"matches", [](const FrameRecord& f) { return f.estimate.times.matches_ns; }},
    {"clique", [](const FrameRecord& f) { return f.estimate.times.clique_ns; }},
    {"motion", [](const FrameRecord& f) { return f.estimate.times.motion_ns; }},
};

std::vector<double> times_ms(const std::vector<FrameRecord>& frames, const Stage& stage) {
  std::vector<double> out;
  out.reserve(frames.size());
  for (const FrameRecord& frame : frames) out.push_back(static_cast<double>(stage.time_ns(frame)) / kNsPerMs);
  return out;
}

std::vector<double> of_valid(const std::vector<FrameRecord>& frames, double (*value)(const vo::Estimate&)) {
  std::vector<double> out;
  for (const FrameRecord& frame : frames) {
    if (frame.estimate.status == Status::valid) out.push_back(value(frame.estimate));
  }
  return out;
}

std::map<Status, int> count_verdicts(const std::vector<FrameRecord>& frames) {
  std::map<Status, int> out;
  for (const FrameRecord& frame : frames) ++out[frame.estimate.status];
  return out;
}

json three(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

json pose_json(const RigidTransform& T) {
  Eigen::Quaterniond q(T.R);
  q.normalize();
  return {{"translation_m", three(T.t)}, {"rotation_wxyz", {q.w(), q.x(), q.y(), q.z()}}};
}

// What was found and what was allowed, of each check that applied; and those that failed.
json checks_json(const vo::Checks& checks) {
  json out = json::object();
  for (std::size_t k = 0; k < vo::kChecks; ++k) {
    const auto check = static_cast<vo::Check>(k);
    const vo::Evidence& e = checks[check];
    if (!e.applies) continue;
    out[vo::check_name(check)] = {{"value", e.value}, {"bound", e.bound}, {"failed", e.fails()}};
  }
  return out;
}

// How many frames failed each check.
std::vector<std::pair<const char*, int>> count_reasons(const std::vector<FrameRecord>& frames) {
  std::vector<std::pair<const char*, int>> out;
  for (std::size_t k = 0; k < vo::kChecks; ++k) {
    const auto check = static_cast<vo::Check>(k);
    const auto count = std::count_if(frames.begin(), frames.end(),
                                     [check](const FrameRecord& f) { return f.estimate.checks[check].fails(); });
    if (count > 0) out.emplace_back(vo::check_name(check), static_cast<int>(count));
  }
  return out;
}

json frame_json(const FrameRecord& frame) {
  const vo::Estimate& e = frame.estimate;
  json times = json::object();
  for (const Stage& stage : kStages) times[stage.name] = static_cast<double>(stage.time_ns(frame)) / kNsPerMs;
  json steps = json::object();
  for (const Stage& step : kSteps) steps[step.name] = static_cast<double>(step.time_ns(frame)) / kNsPerMs;
  times["odometry_steps"] = std::move(steps);
  json out = {{"index", frame.index},
              {"stamp_ns", e.stamp_ns},
              {"status", vo::status_name(e.status)},
              {"status_code", static_cast<int>(e.status)},
              {"features", e.features},
              {"matches", e.matches},
              {"clique", e.clique},
              {"inliers", e.inliers},
              {"reprojection_error_px", e.reprojection_error_px},
              {"eigenvalue_ratio", e.eigenvalue_ratio},
              {"quality", e.quality},
              {"checks", checks_json(e.checks)},
              {"expected_error_px", e.expected_error_px},
              {"disparity_shift_px", e.disparity_shift_px},
              {"T_prev_cur", pose_json(e.T_prev_cur)},
              {"T_world_camera", pose_json(e.T_world_camera)},
              {"times_ms", std::move(times)}};
  if (frame.truth_T_world_camera) {
    const RigidTransform error = e.T_world_camera.inverse() * *frame.truth_T_world_camera;
    out["truth_error"] = {{"translation_m", error.t.norm()}, {"rotation_deg", kDegreesOfARadian * error.angle()}};
  }
  return out;
}

json number_or_null(const std::optional<double>& value) { return value ? json(*value) : json(nullptr); }

json reference_json(const RunReference& reference) {
  const Evaluation e = evaluate(reference.pairs, {});
  json out = {{"name", reference.name}, {"frames", e.frames_compared}, {"path_m", e.path_m}, {"ate_m", e.ate_m}};
  if (reference.align) return out;
  out["t_err_pct"] = number_or_null(e.t_err_pct);
  out["r_err_deg_m"] = number_or_null(e.r_err_deg_m);
  out["end_m"] = e.end_m;
  out["end_pct"] = number_or_null(e.end_pct);
  return out;
}

json calibration_json(const vo::CalibrationCheck& c) {
  return {{"noticeable", c.noticeable()},
          {"compensated", c.compensated},
          {"disparity_offset_px", c.disparity_offset_px},
          {"disparity_offset_sigma_px", c.disparity_offset_sigma_px},
          {"vertical_px", c.vertical_px},
          {"vertical_across_px", c.vertical_across_px},
          {"vertical_down_px", c.vertical_down_px},
          {"vertical_most_px", c.vertical_most_px},
          {"vertical_sigma_px", c.vertical_sigma_px},
          {"rotation_deg", three(c.rotation_deg)},
          {"rotation_sigma_deg", three(c.rotation_sigma_deg)}};
}

std::string reference_text(const RunReference& reference) {
  const Evaluation e = evaluate(reference.pairs, {});
  std::string out = fmt::format("against      {}: ", reference.name);
  if (!reference.align) {
    out += fmt::format("end {:.3f} m off", e.end_m);
    if (e.end_pct) out += fmt::format(" ({:.3f} %)", *e.end_pct);
    if (e.t_err_pct) out += fmt::format(", segments {:.3f} % {:.5f} deg/m", *e.t_err_pct, *e.r_err_deg_m);
    out += ", ";
  }
  return out + fmt::format("ATE {:.4f} m\n", e.ate_m);
}

json vehicle_part_json(const vo::VehiclePart& v) {
  return {{"frames", v.frames},
          {"left_px", v.left_px},
          {"top_px", v.top_px},
          {"right_px", v.right_px},
          {"bottom_px", v.bottom_px}};
}

}  // namespace

Spread spread_of(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto at = [&values](double share) {
    return values[static_cast<std::size_t>(std::lround(share * static_cast<double>(values.size() - 1)))];
  };
  return {at(0.5), at(0.95), values.back()};
}

void RunLog::add(const FrameRecord& record) {
  if (!frames_.empty()) {
    distance_m_ += (record.estimate.T_world_camera.t - frames_.back().estimate.T_world_camera.t).norm();
  }
  frames_.push_back(record);
}

std::vector<std::size_t> RunLog::failed() const {
  std::vector<std::size_t> out;
  for (std::size_t i = 1; i < frames_.size(); ++i) {
    if (frames_[i].estimate.status != Status::valid) out.push_back(i);
  }
  return out;
}

std::string RunLog::summary(double wall_s, const std::optional<RunReference>& reference) const {
  const double frames = static_cast<double>(frames_.size());
  std::string out = fmt::format("frames       {} in {:.2f} s ({:.1f} Hz), {:.3f} m\n", frames_.size(), wall_s,
                                wall_s > 0.0 ? frames / wall_s : 0.0, distance_m_);
  out += "verdicts    ";
  const char* separator = " ";
  for (const auto& [status, count] : count_verdicts(frames_)) {
    // The first frame has nothing to be compared with.
    const bool first = status == Status::no_data && count == 1;
    out += fmt::format("{}{} {}", separator, count, first ? "first" : vo::status_name(status));
    separator = ", ";
  }
  separator = "\nreasons      ";
  for (const auto& [name, count] : count_reasons(frames_)) {
    out += fmt::format("{}{} x {}", separator, count, name);
    separator = ", ";
  }
  if (!skipped_.empty()) {
    const SkippedPairs::Entry& first = skipped_.entries().front();
    out += fmt::format("\nskipped      {} {}, first pair {}: {}: {}", skipped_.count(),
                       skipped_.count() == 1 ? "pair" : "pairs", first.index, first.error.what, first.error.remedy);
  }
  const auto inliers = of_valid(frames_, [](const vo::Estimate& e) { return static_cast<double>(e.inliers); });
  if (!inliers.empty()) {
    const auto quality = spread_of(of_valid(frames_, [](const vo::Estimate& e) { return 1.0 * e.quality; }));
    const auto worst = of_valid(frames_, [](const vo::Estimate& e) { return 1.0 * e.quality; });
    out += fmt::format("\nquality      median {:.0f}, least {:.0f} of 100", quality.median,
                       *std::min_element(worst.begin(), worst.end()));
    const auto error = spread_of(of_valid(frames_, [](const vo::Estimate& e) { return e.reprojection_error_px; }));
    out += fmt::format(
        "\ninliers      median {:.0f}, least {:.0f}; reprojection error median {:.3f} px, most {:.3f} px",
        spread_of(inliers).median, *std::min_element(inliers.begin(), inliers.end()), error.median, error.max);
  }
  if (!frames_.empty()) {
    const vo::Estimate& last = frames_.back().estimate;
    if (!finding_.empty()) out += "\ncameras      " + finding_;
    out +=
        "\nself-check   " + (finding_.empty() ? vo::describe(last.calibration) : "not checked: the cameras come first");
    if (last.vehicle_part.frames > 0) out += "\nview         " + vo::describe(last.vehicle_part);
  }
  out += "\ntime a frame    median       95 %        max\n";
  for (const Stage& stage : kStages) {
    const Spread s = spread_of(times_ms(frames_, stage));
    out += fmt::format("  {:10}{:7.2f} ms {:7.2f} ms {:7.2f} ms\n", stage.name, s.median, s.p95, s.max);
  }
  if (reference && reference->pairs.size() >= 2) out += reference_text(*reference);
  return out;
}

std::string RunLog::stats_json(const drivers::SourceInfo& source, const StereoModel& model, double wall_s,
                               const std::optional<RunReference>& reference) const {
  json verdicts = json::object();
  for (const auto& [status, count] : count_verdicts(frames_)) verdicts[vo::status_name(status)] = count;
  json reasons = json::object();
  for (const auto& [name, count] : count_reasons(frames_)) reasons[name] = count;
  json times = json::object();
  for (const Stage& stage : kStages) {
    const Spread s = spread_of(times_ms(frames_, stage));
    times[stage.name] = {{"median", s.median}, {"p95", s.p95}, {"max", s.max}};
  }
  json out = {{"source", source.description},
              {"camera",
               {{"width", model.width},
                {"height", model.height},
                {"fx_px", model.fx_px},
                {"cx_px", model.cx_px},
                {"cy_px", model.cy_px},
                {"baseline_m", model.baseline_m}}},
              {"summary",
               {{"frames", frames_.size()},
                {"failed", failed().size()},
                {"skipped", skipped_.count()},
                {"distance_m", distance_m_},
                {"wall_s", wall_s},
                {"verdicts", std::move(verdicts)},
                {"reasons", std::move(reasons)},
                {"times_ms", std::move(times)}}},
              {"frames", json::array()}};
  if (reference && reference->pairs.size() >= 2) out["reference"] = reference_json(*reference);
  for (const SkippedPairs::Entry& entry : skipped_.entries()) {
    out["skipped"].push_back({{"index", entry.index}, {"why", entry.error.line()}});
  }
  if (!finding_.empty()) out["finding"] = finding_;
  if (!frames_.empty()) {
    out["calibration"] = calibration_json(frames_.back().estimate.calibration);
    out["vehicle_part"] = vehicle_part_json(frames_.back().estimate.vehicle_part);
  }
  for (const FrameRecord& frame : frames_) out["frames"].push_back(frame_json(frame));
  // Paths need not be UTF-8; the file must be.
  return out.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace cliquevo::tools
