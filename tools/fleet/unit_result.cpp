// SPDX-License-Identifier: BSD-3-Clause
#include "tools/fleet/unit_result.h"

#include <algorithm>
#include <map>
#include <vector>

#include <nlohmann/json.hpp>

namespace cliquevo::tools::fleet {

namespace {

using nlohmann::json;
using vo::Status;

constexpr std::size_t kMostWorst = 5;
constexpr std::int64_t kApart = 8;  // frames: of two bad ones so near, the worse is named

json or_null(const std::optional<double>& value) { return value ? json(*value) : json(nullptr); }

// As pages rank them: refused frames by how far beyond a bound, then valid ones by quality.
double badness(const vo::Estimate& e) {
  if (e.status == Status::no_data) return 0.0;
  if (e.status == Status::valid) return 100.0 - e.quality;
  double most = 0.0;
  for (std::size_t k = 0; k < vo::kChecks; ++k) {
    most = std::max(most, e.checks[static_cast<vo::Check>(k)].ratio());
  }
  return 1000.0 + std::min(most, 100.0);
}

json failed_checks(const vo::Estimate& e) {
  json out = json::array();
  for (std::size_t k = 0; k < vo::kChecks; ++k) {
    const auto check = static_cast<vo::Check>(k);
    if (e.checks[check].fails()) out.push_back(vo::check_name(check));
  }
  return out;
}

json worst_json(const RunLog& log) {
  std::vector<const FrameRecord*> frames;
  for (const FrameRecord& frame : log.frames()) {
    if (badness(frame.estimate) > 0.0) frames.push_back(&frame);
  }
  std::stable_sort(frames.begin(), frames.end(), [](const FrameRecord* a, const FrameRecord* b) {
    return badness(a->estimate) > badness(b->estimate);
  });
  std::vector<const FrameRecord*> kept;
  for (const FrameRecord* frame : frames) {
    const bool near = std::any_of(kept.begin(), kept.end(),
                                  [&](const FrameRecord* k) { return std::abs(k->index - frame->index) < kApart; });
    if (!near) kept.push_back(frame);
    if (kept.size() == kMostWorst) break;
  }
  json out = json::array();
  for (const FrameRecord* frame : kept) {
    const vo::Estimate& e = frame->estimate;
    out.push_back({{"index", frame->index},
                   {"stamp_ns", e.stamp_ns},
                   {"status", vo::status_name(e.status)},
                   {"quality", e.quality},
                   {"badness", badness(e)},
                   {"failed_checks", failed_checks(e)}});
  }
  return out;
}

std::optional<double> median_of_valid(const RunLog& log, double (*value)(const vo::Estimate&)) {
  std::vector<double> values;
  for (const FrameRecord& frame : log.frames()) {
    if (frame.estimate.status == Status::valid) values.push_back(value(frame.estimate));
  }
  if (values.empty()) return std::nullopt;
  return spread_of(std::move(values)).median;
}

json reference_json(const std::optional<RunReference>& reference) {
  if (!reference || reference->pairs.size() < 2) return nullptr;
  const Evaluation e = evaluate(reference->pairs, {});
  json out = {{"frames", e.frames_compared}, {"path_m", e.path_m}, {"ate_m", e.ate_m}};
  if (reference->align) return out;
  out["segments_pct"] = or_null(e.t_err_pct);
  out["rotation_deg_m"] = or_null(e.r_err_deg_m);
  out["end_m"] = e.end_m;
  out["end_pct"] = or_null(e.end_pct);
  return out;
}

}  // namespace

json result_json(const RunLog& log, const StereoModel& model, const std::optional<RunReference>& reference,
                 const std::string& trajectory_sha256) {
  std::map<std::string, int> verdicts;
  std::map<std::string, int> reasons;
  for (const FrameRecord& frame : log.frames()) {
    ++verdicts[vo::status_name(frame.estimate.status)];
    for (const json& check : failed_checks(frame.estimate)) ++reasons[check.get<std::string>()];
  }
  json out = {
      {"frames", log.frames().size()},
      {"failed", log.failed().size()},
      {"skipped", log.skipped().count()},
      {"distance_m", log.distance_m()},
      {"camera",
       {{"width", model.width}, {"height", model.height}, {"fx_px", model.fx_px}, {"baseline_m", model.baseline_m}}},
      {"verdicts", verdicts},
      {"reasons", reasons},
      {"reference", reference_json(reference)},
      {"quality", or_null(median_of_valid(log, [](const vo::Estimate& e) { return 1.0 * e.quality; }))},
      {"inliers", or_null(median_of_valid(log, [](const vo::Estimate& e) { return 1.0 * e.inliers; }))},
      {"error_px", or_null(median_of_valid(log, [](const vo::Estimate& e) { return e.reprojection_error_px; }))},
      {"worst", worst_json(log)},
      {"trajectory_sha256", trajectory_sha256}};
  if (!log.skipped().empty()) {
    const SkippedPairs::Entry& first = log.skipped().entries().front();
    out["first_skipped"] = {{"index", first.index}, {"what", first.error.what}};  // not where: results know no path
  }
  return out;
}

json times_json(const RunLog& log) {
  std::vector<double> times;
  for (const FrameRecord& frame : log.frames()) times.push_back(static_cast<double>(frame.total_ns()) * 1e-6);
  const Spread spread = spread_of(std::move(times));
  return {{"median", spread.median}, {"p95", spread.p95}};
}

}  // namespace cliquevo::tools::fleet
