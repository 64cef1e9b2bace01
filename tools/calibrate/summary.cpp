// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/summary.h"

#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace cliquevo::tools {

namespace {

using namespace calibration;

const char* side_name(Side side) { return side == Side::left ? "left" : "right"; }

double rms_of_side(const CalibrationResult& r, Side side) {
  double squared = 0.0;
  double count = 0.0;
  for (std::size_t v = 0; v < r.solution.views.size(); ++v) {
    const View& view = r.solution.views[v];
    const double rms = rms_px(r.board, r.solution.rig(), r.solution.adjusted.T_left_board[v], view, side);
    squared += rms * rms * static_cast<double>(view.of(side).size());
    count += static_cast<double>(view.of(side).size());
  }
  return count > 0.0 ? std::sqrt(squared / count) : 0.0;
}

nlohmann::json parameters_of(const Adjusted& a) {
  nlohmann::json out = nlohmann::json::object();
  const auto put = [&](int index, double value) {
    const double variance = a.covariance(index, index);
    if (!(variance > 0.0)) return;
    out[shared_name(a.rig, index)] = {{"value", value}, {"sigma", std::sqrt(variance)}};
  };
  for (int i = 0; i < a.rig.model->size(); ++i) {
    put(i, a.rig.left(i));
    put(kFirstOfRight + i, a.rig.right(i));
  }
  const Eigen::Vector3d turn = so3_log(a.rig.T_right_left.R);
  for (int i = 0; i < 3; ++i) {
    put(kFirstOfPose + i, a.rig.T_right_left.t(i));
    put(kFirstOfPose + 3 + i, turn(i));
  }
  for (int i = 0; i < 2; ++i) put(kFirstOfBend + i, a.rig.bend_m(i));
  return out;
}

nlohmann::json views_of(const CalibrationResult& r) {
  nlohmann::json out = nlohmann::json::array();
  for (std::size_t v = 0; v < r.solution.views.size(); ++v) {
    const View& view = r.solution.views[v];
    nlohmann::json row = {{"name", view.name}};
    for (const Side side : {Side::left, Side::right}) {
      row[side_name(side)] = {
          {"corners", view.of(side).size()},
          {"rms_px", rms_px(r.board, r.solution.rig(), r.solution.adjusted.T_left_board[v], view, side)}};
    }
    out.push_back(row);
  }
  return out;
}

nlohmann::json to_json(const HeldOut& h) {
  return {{"row_rms_px", h.row_rms_px}, {"reprojection_rms_px", h.reprojection_rms_px}, {"corners", h.corners}};
}

std::string worst_corners(const Solution& s) {
  std::string out;
  constexpr std::size_t kMost = 5;
  for (std::size_t i = 0; i < std::min(kMost, s.dropped_corners.size()); ++i) {
    const DroppedCorner& c = s.dropped_corners[i];
    out += fmt::format("  {}, {} image: corner {} is {:.2f} px off\n", c.view, side_name(c.side), c.id, c.error_px);
  }
  if (s.dropped_corners.size() > kMost) out += fmt::format("  ... and {} more\n", s.dropped_corners.size() - kMost);
  return out;
}

std::string bend_sentence(const CalibrationResult& r) {
  const Adjusted& a = r.solution.adjusted;
  const Eigen::Vector2d sigma = a.covariance.diagonal().tail<2>().cwiseSqrt();
  const bool clear = a.rig.bend_m.cwiseAbs().cwiseQuotient(sigma.cwiseMax(1e-12)).maxCoeff() > 3.0;
  return fmt::format(
      "board      {}: {:.2f} +- {:.2f} mm along x, {:.2f} +- {:.2f} mm along y; its size is as named: no "
      "image can show it\n",
      clear ? "bent, and that is allowed for" : "flat as far as can be seen", 1e3 * a.rig.bend_m.x(), 1e3 * sigma.x(),
      1e3 * a.rig.bend_m.y(), 1e3 * sigma.y());
}

std::string found_sentence(const Collected& c) {
  std::string out = fmt::format("found      the board in {} of {} pairs", c.pairs - c.without, c.pairs);
  if (c.alike > 0) out += fmt::format("; {} are as good as another one", c.alike);
  if (c.moving > 0) out += fmt::format("; in {} it moved", c.moving);
  return out + "\n";
}

std::string advice(const CalibrationResult& r) {
  std::string out;
  constexpr double kLittleTilt_deg = 30.0;
  constexpr std::size_t kFewViews = 15;
  if (!r.coverage.hole.empty())
    out += fmt::format("hint: no corner in the {}: hold the board there\n", r.coverage.hole);
  if (r.coverage.tilt_deg < kLittleTilt_deg) {
    out +=
        fmt::format("hint: views differ by {:.0f} degrees of tilt at most: tilt the board more\n", r.coverage.tilt_deg);
  }
  if (r.solution.views.size() < kFewViews) {
    out += fmt::format("hint: {} views: 20 to 40 make it twice as certain\n", r.solution.views.size());
  }
  return out;
}

}  // namespace

nlohmann::json to_json(const CalibrationResult& r) {
  const Solution& s = r.solution;
  nlohmann::json out = {
      {"board", r.board.text()},
      {"model", s.rig().model->name},
      {"width", s.rig().width},
      {"height", s.rig().height},
      {"pairs", r.collected.pairs},
      {"pairs_without_board", r.collected.without},
      {"pairs_alike", r.collected.alike},
      {"pairs_moving", r.collected.moving},
      {"views", views_of(r)},
      {"views_used", s.views.size()},
      {"views_dropped", s.dropped_views},
      {"corners_dropped", s.dropped_corners.size()},
      {"rms_px", rms_px(r.board, s)},
      {"rms_left_px", rms_of_side(r, Side::left)},
      {"rms_right_px", rms_of_side(r, Side::right)},
      {"sigma_px", s.adjusted.sigma_px},
      {"baseline_m", s.rig().T_right_left.t.norm()},
      {"baseline_sigma_m", r.accuracy.baseline_m},
      {"held_out", to_json(s.held_out)},
      {"parameters", parameters_of(s.adjusted)},
      {"accuracy",
       {{"rotation_deg", r.accuracy.rotation_deg},
        {"drift_pct", r.accuracy.drift_percent},
        {"depth_m", nlohmann::json::array()}}},
      {"coverage",
       {{"left", r.coverage.filled[0]},
        {"right", r.coverage.filled[1]},
        {"tilt_deg", r.coverage.tilt_deg},
        {"nearest_m", r.coverage.nearest_m},
        {"farthest_m", r.coverage.farthest_m},
        {"hole", r.coverage.hole}}},
      {"models", nlohmann::json::array()},
  };
  for (std::size_t i = 0; i < kJudgedDepths_m.size(); ++i) {
    out["accuracy"]["depth_m"].push_back({{"at_m", kJudgedDepths_m[i]}, {"sigma_m", r.accuracy.depth_m[i]}});
  }
  for (const Solution::Tried& tried : s.tried) {
    nlohmann::json row = to_json(tried.held_out);
    row["model"] = tried.model;
    out["models"].push_back(row);
  }
  if (r.movement) {
    const Movement& m = *r.movement;
    out["compared"] = {{"with", r.compared_with},
                       {"rows_px", m.rows_px},
                       {"rotation_deg", m.rotation_deg},
                       {"depth", nlohmann::json::array()}};
    for (std::size_t i = 0; i < kJudgedDepths_m.size(); ++i) {
      out["compared"]["depth"].push_back(
          {{"at_m", kJudgedDepths_m[i]}, {"error_m", m.depth_m[i]}, {"sigmas", m.depth_sigmas[i]}});
    }
  }
  return out;
}

std::string summary_of(const CalibrationResult& r) {
  const Solution& s = r.solution;
  const Rig& rig = s.rig();
  const auto sigma = [&](int i) { return std::sqrt(s.adjusted.covariance(i, i)); };
  std::size_t corners = s.dropped_corners.size();
  for (const View& view : s.views) corners += view.left.size() + view.right.size();
  std::string out = found_sentence(r.collected);
  out += fmt::format("used       {} views, without {} of {} corners; lens model {}\n", s.views.size(),
                     s.dropped_corners.size(), corners, rig.model->name);
  for (const std::string& name : s.dropped_views) {
    out += fmt::format("  {} does not fit the others: moved, or not this board\n", name);
  }
  out += worst_corners(s);
  for (const Side side : {Side::left, Side::right}) {
    const LensVector& lens = rig.lens(side);
    const int first = side == Side::left ? 0 : kFirstOfRight;
    out += fmt::format(
        "{:<10} f {:.3f} +- {:.3f}, {:.3f} +- {:.3f} px; centre {:.2f} +- {:.2f}, {:.2f} +- {:.2f} px; "
        "error {:.3f} px\n",
        side_name(side), lens(0), sigma(first), lens(1), sigma(first + 1), lens(2), sigma(first + 2), lens(3),
        sigma(first + 3), rms_of_side(r, side));
  }
  out += fmt::format("rig        baseline {:.3f} +- {:.3f} mm, rotation between the cameras {:.4f} +- {:.4f} degrees\n",
                     1e3 * rig.T_right_left.t.norm(), 1e3 * r.accuracy.baseline_m,
                     180.0 / M_PI * rig.T_right_left.angle(), r.accuracy.rotation_deg);
  out += fmt::format("errors     {:.3f} px RMS a corner; on views held out {:.3f} px a coordinate, rows {:.3f} px\n",
                     rms_px(r.board, s), s.held_out.reprojection_rms_px, s.held_out.row_rms_px);
  out += bend_sentence(r);
  out += fmt::format("worth      depth at 5, 10, 20 m: +- {:.3f}, {:.3f}, {:.3f} m; drift {:.3f} % of the way\n",
                     r.accuracy.depth_m[0], r.accuracy.depth_m[1], r.accuracy.depth_m[2], r.accuracy.drift_percent);
  out += fmt::format("coverage   left {:.0f} %, right {:.0f} %; tilt up to {:.0f} degrees; {:.2f} to {:.2f} m away\n",
                     100.0 * r.coverage.filled[0], 100.0 * r.coverage.filled[1], r.coverage.tilt_deg,
                     r.coverage.nearest_m, r.coverage.farthest_m);
  if (r.movement) {
    out += fmt::format(
        "compared   with {}: its depth at 10 m is off by {:.3f} m ({:.1f} sigma), its rows by {:.3f} px, "
        "the cameras turned by {:.4f} degrees\n",
        r.compared_with, r.movement->depth_m[1], r.movement->depth_sigmas[1], r.movement->rows_px,
        r.movement->rotation_deg);
  }
  return out + advice(r);
}

nlohmann::json to_json(const DrivenCalibration& d) {
  nlohmann::json out = {
      {"changed", d.changed},
      {"turned_deg", {d.turned_deg.x(), d.turned_deg.y(), d.turned_deg.z()}},
      {"sigma_deg", {d.sigma_deg.x(), d.sigma_deg.y(), d.sigma_deg.z()}},
      {"focal_ratio", d.focal_ratio},
      {"focal_ratio_sigma", d.focal_ratio_sigma},
      {"not_observable", {"baseline_m", "left lens", "right distortion and centre", "baseline direction"}},
      {"baseline_m", d.calibration.T_right_left.t.norm()},
      {"runs", nlohmann::json::array()}};
  for (const DrivenRun& run : d.runs) {
    const Eigen::Vector3d& turn = run.check.rotation_deg;
    const Eigen::Vector3d& sigma = run.check.rotation_sigma_deg;
    out["runs"].push_back(
        {{"frames", run.frames},
         {"valid", run.valid},
         {"way_m", run.way_m},
         {"reprojection_px", run.reprojection_px},
         {"rotation_deg", {turn.x(), turn.y(), turn.z()}},
         {"rotation_sigma_deg", {sigma.x(), sigma.y(), sigma.z()}},
         {"focal_ratio_error", run.check.focal_ratio_error},
         {"focal_ratio_sigma", run.check.focal_ratio_sigma},
         {"rows_px", run.check.vertical_most_px},
         {"end_pct", run.end_error_percent ? nlohmann::json(*run.end_error_percent) : nlohmann::json(nullptr)}});
  }
  return out;
}

std::string summary_of(const DrivenCalibration& d) {
  std::string out;
  for (std::size_t i = 0; i < d.runs.size(); ++i) {
    const DrivenRun& run = d.runs[i];
    const Eigen::Vector3d& turn = run.check.rotation_deg;
    const Eigen::Vector3d& sigma = run.check.rotation_sigma_deg;
    out += fmt::format(
        "run {}      {} of {} frames valid, {:.1f} m; left over between the cameras: {:.4f} +- {:.4f}, "
        "{:.4f} +- {:.4f}, {:.4f} +- {:.4f} degrees about x, y, z; focal length of the right one {:+.3f} +- {:.3f} %; "
        "rows up to {:.2f} px{}\n",
        i + 1, run.valid, run.frames, run.way_m, turn.x(), sigma.x(), turn.y(), sigma.y(), turn.z(), sigma.z(),
        100.0 * run.check.focal_ratio_error, 100.0 * run.check.focal_ratio_sigma, run.check.vertical_most_px,
        run.end_error_percent ? fmt::format("; end off by {:.2f} %", *run.end_error_percent) : "");
  }
  out += "not seen in a drive: the baseline (a way as much too long), its direction, and the lenses apart from that\n";
  if (!d.changed) return out + "the calibration agrees with the drive: it is written as it was\n";
  if (d.focal_ratio != 1.0) {
    out += fmt::format("the right camera's focal lengths are {:.5f} +- {:.5f} times the old ones\n", d.focal_ratio,
                       d.focal_ratio_sigma);
  }
  return out + fmt::format(
                   "the right camera is turned by {:.4f}, {:.4f}, {:.4f} degrees about x, y, z against the old "
                   "calibration\n",
                   d.turned_deg.x(), d.turned_deg.y(), d.turned_deg.z());
}

}  // namespace cliquevo::tools
