// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/vo_params.h"

#include <cmath>
#include <string>

namespace cliquevo::vo {

namespace {

Error out_of_range(const char* name, const char* range) {
  return {"odometry parameter out of range", name, std::string("choose ") + range};
}

bool within(double value, double low, double high) { return std::isfinite(value) && value >= low && value <= high; }

}  // namespace

Result<void> VoParams::check() const {
  if (!within(max_features, 50, 1000)) return out_of_range("max_features", "50 to 1000");
  if (!within(cell_px, 16, 256)) return out_of_range("cell_px", "16 to 256");
  if (!within(min_corner_threshold, 1, 128)) return out_of_range("min_corner_threshold", "1 to 128");
  if (!within(corner_threshold, min_corner_threshold, 128)) {
    return out_of_range("corner_threshold", "min_corner_threshold to 128");
  }
  if (descriptor_window < 5 || descriptor_window > 11 || descriptor_window % 2 == 0) {
    return out_of_range("descriptor_window", "5, 7, 9 or 11");
  }
  if (!within(consistency_delta_m, 0.0, 10.0)) return out_of_range("consistency_delta_m", "0 to 10");
  if (!within(consistency_sigmas, 0.5, 20.0)) return out_of_range("consistency_sigmas", "0.5 to 20");
  if (!within(match_sigma_px, 0.01, 10.0)) return out_of_range("match_sigma_px", "0.01 to 10");
  if (!within(match_disparity_sigma_px, 0.01, 10.0)) return out_of_range("match_disparity_sigma_px", "0.01 to 10");
  if (!within(refine_radius_px, 2, 7)) return out_of_range("refine_radius_px", "2 to 7");
  if (!within(refine_iterations, 1, 50)) return out_of_range("refine_iterations", "1 to 50");
  if (!within(min_patch_correlation, 0.3, 1.0)) return out_of_range("min_patch_correlation", "0.3 to 1");
  if (!within(sigma_px, 0.01, 10.0)) return out_of_range("sigma_px", "0.01 to 10");
  if (!within(disparity_sigma_px, 0.01, 10.0)) return out_of_range("disparity_sigma_px", "0.01 to 10");
  if (!within(key_frame_overlap, 0.05, 1.0)) return out_of_range("key_frame_overlap", "0.05 to 1");
  if (!within(solver_iterations, 1, 100)) return out_of_range("solver_iterations", "1 to 100");
  if (!within(huber_sigmas, 0.1, 100.0)) return out_of_range("huber_sigmas", "0.1 to 100");
  if (!within(trim_sigmas, 1.0, 100.0)) return out_of_range("trim_sigmas", "1 to 100");
  if (!within(min_inliers, 3, 500)) return out_of_range("min_inliers", "3 to 500");
  if (!within(min_eigenvalue_ratio, 0.0, 1.0)) return out_of_range("min_eigenvalue_ratio", "0 to 1");
  if (!within(max_error_ratio, 0.1, 100.0)) return out_of_range("max_error_ratio", "0.1 to 100");
  if (!within(rival_share, 0.1, 1.0)) return out_of_range("rival_share", "0.1 to 1");
  if (!within(max_contradiction, 0.01, 1.0)) return out_of_range("max_contradiction", "0.01 to 1");
  if (!within(max_running_ground, 0.1, 1000.0)) return out_of_range("max_running_ground", "0.1 to 1000");
  if (!within(max_uncertainty, 0.001, 100.0)) return out_of_range("max_uncertainty", "0.001 to 100");
  if (!within(min_mover_points, 4, 500)) return out_of_range("min_mover_points", "4 to 500");
  return {};
}

}  // namespace cliquevo::vo
