// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/checks.h"

#include <algorithm>
#include <cmath>

namespace cliquevo::vo {

namespace {

// Correlations: where patches hardly change and hardly differ, their ratio means nothing.
constexpr double kLeastDifference = 0.01;
constexpr double kStrictest = 0.5;            // share of the bound on disparities that remains with little coverage
constexpr double kUsualDisparityError = 1.4;  // expected errors; the median is 0.7 to 1.3 on every recording
constexpr double kMostNews = 3.0;             // factor by which an unexpected error of the disparities counts
constexpr double kOffsetNoise_px = 0.15;      // of one frame's reading of an error common to all disparities
constexpr double kMostRunning_px = 2.0;       // a larger one comes from the calibration, and is learned
constexpr double kMoves = 6.0;                // a camera moves when its image does by so many expected errors, ...
constexpr double kStands = 4.0;               // ... and stands beside it when its own moves so many times less
constexpr double kRepeats = 100.0;            // ... and for certain where its image is the same to the last bit
// Share of the references' features that must be found where a motion has them; after a suspicious frame, more.
constexpr double kFound = 0.04;
constexpr double kFoundAgain = 0.125;
// Depth-less floor of what is known well enough: a standing vehicle's motion is 0, and nothing is a share of that.
constexpr double kFloorOfDepth = 0.003;  // of the inliers' median distance

template <typename F>
double median_of_inliers(const std::vector<Observation>& observations, std::vector<float>& scratch, F&& value) {
  scratch.clear();
  for (const Observation& o : observations) {
    if (o.inlier && o.reference == 0) scratch.push_back(static_cast<float>(value(o)));
  }
  if (scratch.empty()) return 0.0;
  const auto middle = scratch.begin() + static_cast<std::ptrdiff_t>(scratch.size() / 2);
  std::nth_element(scratch.begin(), middle, scratch.end());
  return static_cast<double>(*middle);
}

// Ground that runs, seen near and far at once, does not fit one motion with the disparities as they are known: the
// residuals imply an error common to all of them, which should be known by now. 1 (nothing new) to 3.
double news_of_disparities(const Motion& motion, double shift_sigma_px) {
  if (!(motion.offset_information > 0.0) || std::abs(motion.offset_px) > kMostRunning_px) return 1.0;
  const double variance =
      kOffsetNoise_px * kOffsetNoise_px + shift_sigma_px * shift_sigma_px + 1.0 / motion.offset_information;
  return std::min(kMostNews, 1.0 + motion.offset_px * motion.offset_px / variance);
}

}  // namespace

void check_solution(const CheckInput& f, const CameraNoise& noise, const Caution& caution, const VoParams& params,
                    Checks& checks) {
  checks[Check::inliers] = check_inliers(f, params);
  checks[Check::spread] = check_spread(f, params);
  checks[Check::positions] = check_positions(f, noise, params);
  checks[Check::disparities] = check_disparities(f, noise, params);
  if (params.refine) checks[Check::found_again] = check_found_again(f, caution);
}

Evidence check_inliers(const CheckInput& f, const VoParams& params) {
  return {static_cast<double>(params.min_inliers) / std::max(1, f.motion.inliers), 1.0, true};
}

Evidence check_spread(const CheckInput& f, const VoParams& params) {
  const double ratio = f.motion.converged ? spread_ratio(f.observations) : 0.0;
  return {params.min_eigenvalue_ratio / std::max(ratio, 1e-9), 1.0, f.motion.inliers >= params.min_inliers};
}

Evidence check_positions(const CheckInput& f, const CameraNoise& noise, const VoParams& params) {
  return {f.motion.error_px / noise.expected_error_px(), params.max_error_ratio, true};
}

Evidence check_disparities(const CheckInput& f, const CameraNoise& noise, const VoParams& params) {
  return {disparity_error_px(f) / noise.expected_error_px(), std::max(f.covered, kStrictest) * params.max_error_ratio,
          params.refine};
}

Evidence check_contradiction(const CellVotes& votes, const Caution& caution, const VoParams& params) {
  return {votes.share(), caution.bound_scale() * params.max_contradiction, true};
}

Evidence check_running_ground(const CheckInput& f, const CameraNoise& noise, const Caution& caution,
                              const VoParams& params, std::vector<float>& scratch) {
  const double change = median_of_inliers(f.observations, scratch, [](const Observation& o) { return o.change; });
  const double difference =
      median_of_inliers(f.observations, scratch, [](const Observation& o) { return o.difference; });
  const double excess = (change - difference) / std::max(kLeastDifference, std::min(std::max(change, 0.0), difference));
  const double scatter = f.motion.error_px / noise.expected_error_px();
  // Ground that runs takes its depths with it: they fit no motion well.
  const double misfit = std::max(1.0, disparity_error_px(f) / noise.expected_error_px() / kUsualDisparityError);
  return {std::max(0.0, excess) * scatter * misfit * news_of_disparities(f.motion, f.shift_sigma_px),
          caution.bound_scale() * params.max_running_ground, true};
}

Evidence check_hanging_camera(const CheckInput& f, const CameraNoise& noise, std::vector<float>& scratch) {
  if (f.camera_repeats) return {kRepeats, kStands, true};
  const auto moved = [&](double share_of_disparity) {
    return median_of_inliers(f.observations, scratch, [&](const Observation& o) {
      const Eigen::Vector3d by = o.uvd_cur - o.uvd_ref;
      return std::hypot(by.x() - share_of_disparity * (by.z() - f.motion.shift_px), by.y());
    });
  };
  const double left_px = moved(0.0);
  const double right_px = moved(1.0);
  const double expected = noise.expected_error_px();
  const double more = std::max(left_px, right_px);
  const double less = std::max(std::min(left_px, right_px), expected);
  return {more / less, kStands, more > kMoves * expected};
}

Evidence check_found_again(const CheckInput& f, const Caution& caution) {
  const double least = caution.any() ? kFoundAgain : kFound;
  return {least * f.reference_features / std::max(1, f.motion.inliers), 1.0, true};
}

Evidence check_uncertainty(const CheckInput& f, const Matrix6d& covariance, const VoParams& params) {
  double depth_m = 0.0;
  int n = 0;
  for (const Observation& o : f.observations) {
    if (!o.inlier) continue;
    depth_m += 1.0 / f.model.depth_m(std::max(o.uvd_ref.z(), kMinDisparity_px - f.model.doffs_px));
    ++n;
  }
  depth_m = n > 0 ? n / depth_m : 0.0;  // harmonic mean: the near ones fix the translation
  const double known_m = std::max(params.max_uncertainty * f.motion.T_prev_cur.t.norm(), kFloorOfDepth * depth_m);
  const double sigma_m = std::sqrt(std::max(0.0, covariance.topLeftCorner<3, 3>().trace()));
  return {sigma_m / std::max(known_m, 1e-9), 1.0, true};
}

double spread_ratio(const std::vector<Observation>& observations) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
  for (const Observation& o : observations) {
    if (!o.inlier) continue;
    const double x = o.uvd_cur.x();
    const double y = o.uvd_cur.y();
    n += 1;
    sx += x;
    sy += y;
    sxx += x * x;
    sxy += x * y;
    syy += y * y;
  }
  if (n < 3) return 0.0;
  sxx = sxx / n - sx / n * (sx / n);
  sxy = sxy / n - sx / n * (sy / n);
  syy = syy / n - sy / n * (sy / n);
  const double half_trace = 0.5 * (sxx + syy);
  const double root = std::sqrt(std::max(0.0, half_trace * half_trace - (sxx * syy - sxy * sxy)));
  const double larger = half_trace + root;
  return larger > 0.0 ? std::max(0.0, half_trace - root) / larger : 0.0;
}

double disparity_error_px(const CheckInput& f) {
  const RigidTransform T_cur_prev = f.motion.T_prev_cur.inverse();
  double n = 0.0, sum = 0.0;
  for (const Observation& o : f.observations) {
    if (!o.inlier) continue;
    const Eigen::Vector3d in_ref = f.model.triangulate(o.uvd_ref.x(), o.uvd_ref.y(), o.uvd_ref.z());
    const Eigen::Vector3d p = T_cur_prev * (f.T_prev_ref[static_cast<std::size_t>(o.reference)] * in_ref);
    const double error = o.uvd_cur.z() - f.motion.shift_px - f.model.project(p).z();
    n += 1.0;
    sum += error * error;
  }
  return n > 0.0 ? std::sqrt(sum / n) : 0.0;
}

double change_of_light(const std::vector<Observation>& observations, std::vector<float>& scratch) {
  scratch.clear();
  for (const Observation& o : observations) {
    if (o.inlier && o.reference == 0) scratch.push_back(o.brighter);
  }
  if (scratch.empty()) return 0.0;
  const auto smallest_but = [&scratch](std::size_t tenths) {
    const auto at = scratch.begin() + static_cast<std::ptrdiff_t>(scratch.size() * tenths / 10);
    std::nth_element(scratch.begin(), at, scratch.end());
    return *at;
  };
  const float common = smallest_but(5);
  for (float& brighter : scratch) brighter = std::abs(brighter - common);
  return static_cast<double>(smallest_but(9));
}

}  // namespace cliquevo::vo
