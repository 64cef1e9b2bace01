// SPDX-License-Identifier: BSD-3-Clause
#include "tools/evaluation_json.h"

#include <optional>

namespace cliquevo::tools {

namespace {

nlohmann::json optional_number(const std::optional<double>& value) {
  return value ? nlohmann::json(*value) : nlohmann::json(nullptr);
}

}  // namespace

nlohmann::json to_json(const Evaluation& e) {
  nlohmann::json out = {
      {"frames_ref", e.frames_reference},
      {"frames_est", e.frames_estimate},
      {"frames_compared", e.frames_compared},
      {"path_m", e.path_m},
      {"path_est_m", e.path_estimate_m},
      {"segments", e.segments},
      {"t_err_pct", optional_number(e.t_err_pct)},
      {"r_err_deg_m", optional_number(e.r_err_deg_m)},
      {"ate_m", e.ate_m},
      {"ate_max_m", e.ate_max_m},
      {"rpe_cm", 100.0 * e.rpe_m},
      {"rpe_deg", e.rpe_deg},
      {"end_m", e.end_m},
      {"end_deg", e.end_deg},
      {"end_pct", optional_number(e.end_pct)},
      {"by_length", nlohmann::json::array()},
  };
  for (const LengthError& entry : e.by_length) {
    const bool any = entry.segments > 0;
    out["by_length"].push_back({{"length_m", entry.length_m},
                                {"segments", entry.segments},
                                {"t_err_pct", any ? nlohmann::json(entry.t_err_pct) : nlohmann::json(nullptr)},
                                {"r_err_deg_m", any ? nlohmann::json(entry.r_err_deg_m) : nlohmann::json(nullptr)}});
  }
  if (e.sampled_path_m) {
    out["sampled_path_m"] = *e.sampled_path_m;
    out["sampled_path_est_m"] = *e.sampled_path_estimate_m;
  }
  return out;
}

std::string evaluation_json(const Evaluation& evaluation) { return to_json(evaluation).dump(2); }

}  // namespace cliquevo::tools
