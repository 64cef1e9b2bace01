// SPDX-License-Identifier: BSD-3-Clause
#include "tools/plot.h"

#include <algorithm>

#include <fmt/format.h>

#include "tools/chart.h"

namespace cliquevo::tools {

namespace {

constexpr int kWidth = 1600;
constexpr int kHeight = 760;
constexpr int kHeader = 46;

// Colours that those who see no red or no green distinguish too (Okabe and Ito); shapes and dashes do so in grey.
constexpr Color kBlue{0, 114, 178};
constexpr Color kGrey{110, 110, 110};
constexpr Color kRed{213, 75, 0};
constexpr Color kGreen{0, 140, 105};
constexpr Color kDark{50, 50, 50};

// The map: X to the right, Z up.
Point from_above(const Eigen::Vector3d& p) { return {p.x(), p.z()}; }

std::vector<double> own_distances(const std::vector<RigidTransform>& poses) {
  std::vector<double> out(poses.size(), 0.0);
  for (std::size_t i = 1; i < poses.size(); ++i) out[i] = out[i - 1] + (poses[i].t - poses[i - 1].t).norm();
  return out;
}

std::string summary(const RunPicture& run, const AgainstReference& comparison) {
  std::string out = fmt::format("{} frames, {:.1f} m", run.trajectory.size(), own_distances(run.trajectory).back());
  if (!comparison.error_m.empty()) {
    const double error_m = comparison.error_m.back();
    const double way_m = comparison.distance_m.back();
    out += fmt::format(", {:.3f} m off at the end", error_m);
    if (way_m > 0.0) out += fmt::format(" ({:.2f} %)", 100.0 * error_m / way_m);
  }
  return out;
}

Chart map_chart(const RunPicture& run, const AgainstReference& comparison) {
  Chart chart;
  chart.title = "Trajectory from above";
  chart.x_label = "X, right [m]";
  chart.y_label = "Z, forward [m]";
  chart.equal_aspect = true;
  if (!comparison.reference.empty()) {
    Series reference{"reference", {}, kGrey, 3.0, Mark::none, 0.0, true};
    for (const Eigen::Vector3d& p : comparison.reference) reference.points.push_back(from_above(p));
    chart.series.push_back(std::move(reference));
  }
  Series estimate{"estimate", {}, kBlue, 2.5, Mark::none, 0.0, false};
  for (const RigidTransform& pose : run.trajectory) estimate.points.push_back(from_above(pose.t));
  const Point start = estimate.points.front();
  const Point end = estimate.points.back();
  chart.series.push_back(std::move(estimate));
  if (!run.failed.empty()) {
    Series failed{fmt::format("failed frames ({})", run.failed.size()), {}, kRed, 0.0, Mark::cross, 4.5, false};
    for (const std::size_t i : run.failed) failed.points.push_back(from_above(run.trajectory[i].t));
    chart.series.push_back(std::move(failed));
  }
  chart.series.push_back({"start", {start}, kGreen, 0.0, Mark::ring, 6.5, false});
  chart.series.push_back({"end", {end}, kDark, 0.0, Mark::square, 5.5, false});
  return chart;
}

Chart error_chart(const AgainstReference& comparison, bool aligned) {
  Chart chart;
  chart.title = aligned ? "Position error after alignment" : "Position error";
  chart.x_label = "distance travelled [m]";
  chart.y_label = "error [m]";
  chart.from_zero = true;
  Series error{"", {}, kBlue, 2.0, Mark::none, 0.0, false};
  for (std::size_t i = 0; i < comparison.error_m.size(); ++i) {
    error.points.push_back({comparison.distance_m[i], comparison.error_m[i]});
  }
  chart.series.push_back(std::move(error));
  return chart;
}

Chart inlier_chart(const RunPicture& run) {
  const std::vector<double> distance_m = own_distances(run.trajectory);
  Chart chart;
  chart.title = "Features that carry the motion";
  chart.x_label = "distance travelled [m]";
  chart.y_label = "inliers";
  chart.from_zero = true;
  Series inliers{"", {}, kGreen, 1.5, Mark::none, 0.0, false};
  for (std::size_t i = 1; i < run.inliers.size(); ++i)
    inliers.points.push_back({distance_m[i], static_cast<double>(run.inliers[i])});
  chart.series.push_back(std::move(inliers));
  if (!run.failed.empty()) {
    Series failed{"failed frames", {}, kRed, 0.0, Mark::cross, 4.5, false};
    for (const std::size_t i : run.failed)
      failed.points.push_back({distance_m[i], static_cast<double>(run.inliers[i])});
    chart.series.push_back(std::move(failed));
  }
  return chart;
}

Chart height_chart(const RunPicture& run, const AgainstReference& comparison) {
  const std::vector<double> distance_m = own_distances(run.trajectory);
  Chart chart;
  chart.title = "Height";
  chart.x_label = "distance travelled [m]";
  chart.y_label = "-Y, up [m]";
  if (!comparison.reference.empty()) {
    Series reference{"reference", {}, kGrey, 2.5, Mark::none, 0.0, true};
    for (std::size_t i = 0; i < comparison.reference.size(); ++i) {
      reference.points.push_back({comparison.distance_m[i], -comparison.reference[i].y()});
    }
    chart.series.push_back(std::move(reference));
  }
  Series height{comparison.reference.empty() ? "" : "estimate", {}, kBlue, 2.0, Mark::none, 0.0, false};
  for (std::size_t i = 0; i < run.trajectory.size(); ++i) {
    height.points.push_back({distance_m[i], -run.trajectory[i].t.y()});
  }
  chart.series.push_back(std::move(height));
  return chart;
}

}  // namespace

AgainstReference against_reference(const std::vector<PosePair>& pairs, bool align) {
  AgainstReference out;
  if (pairs.empty()) return out;
  RigidTransform T_world_reference = pairs.front().estimate * pairs.front().reference.inverse();
  if (align) {
    std::vector<Eigen::Vector3d> from;
    std::vector<Eigen::Vector3d> to;
    for (const PosePair& pair : pairs) {
      from.push_back(pair.reference.t);
      to.push_back(pair.estimate.t);
    }
    T_world_reference = align_rigid(from, to);
  }
  out.distance_m = distances_m(pairs);
  for (const PosePair& pair : pairs) {
    out.reference.push_back(T_world_reference * pair.reference.t);
    out.error_m.push_back((out.reference.back() - pair.estimate.t).norm());
  }
  return out;
}

Result<std::vector<unsigned char>> draw_plot(const RunPicture& run, PictureFormat format) {
  if (run.trajectory.empty()) return Error{"cannot draw plot", run.title, "no frame was processed"};
  const AgainstReference comparison = against_reference(run.pairs, run.align);
  const bool referenced = !run.pairs.empty();
  const bool inliers = run.inliers.size() == run.trajectory.size();

  Figure figure(kWidth, kHeight, format);
  figure.text(run.title + ": " + summary(run, comparison), {24, kHeader / 2.0 + 4}, 19, kDark);
  constexpr double kMap = 820;
  figure.draw(map_chart(run, comparison), {8, kHeader, kMap, kHeight - kHeader});
  std::vector<Chart> beside;
  if (referenced) beside.push_back(error_chart(comparison, run.align));
  if (!referenced || !inliers) beside.push_back(height_chart(run, comparison));
  if (inliers) beside.push_back(inlier_chart(run));
  const double height = (kHeight - kHeader) / static_cast<double>(beside.size());
  for (std::size_t i = 0; i < beside.size(); ++i) {
    figure.draw(beside[i], {kMap + 16, kHeader + height * static_cast<double>(i), kWidth - kMap - 24, height});
  }
  return figure.encoded();
}

}  // namespace cliquevo::tools
