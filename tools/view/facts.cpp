// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view/facts.h"

#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace cliquevo::view {

namespace {

using Out = fmt::memory_buffer;

// JSON knows no nan and no infinity.
double finite(double value) { return std::isfinite(value) ? value : 0.0; }

void put(Out& out, const char* key, double value, int digits = 6) {
  fmt::format_to(std::back_inserter(out), ",\"{}\":{:.{}g}", key, finite(value), digits);
}
void put(Out& out, const char* key, std::int64_t value) {
  fmt::format_to(std::back_inserter(out), ",\"{}\":{}", key, value);
}
void put_list(Out& out, const char* key, const double* values, std::size_t count, int digits) {
  fmt::format_to(std::back_inserter(out), ",\"{}\":[", key);
  for (std::size_t i = 0; i < count; ++i) {
    fmt::format_to(std::back_inserter(out), "{}{:.{}g}", i > 0 ? "," : "", finite(values[i]), digits);
  }
  out.push_back(']');
}
void put_text(Out& out, const char* text) { fmt::format_to(std::back_inserter(out), "{}", text); }

void put_pose(Out& out, const FrameFacts& f) {
  put_list(out, "p", f.T_world_body.t.data(), 3, 8);
  Eigen::Quaterniond q(f.T_world_body.R);
  q.normalize();
  const double wxyz[] = {q.w(), q.x(), q.y(), q.z()};
  put_list(out, "o", wxyz, 4, 6);
  const Eigen::Matrix3d& c = f.position_m2;
  const double six[] = {c(0, 0), c(1, 1), c(2, 2), c(0, 1), c(0, 2), c(1, 2)};
  put_list(out, "cv", six, 6, 4);
}

void put_checks(Out& out, const FrameFacts& f) {
  put_text(out, ",\"ck\":[");
  for (std::size_t k = 0; k < f.checks.size(); ++k) {
    const CheckFact& c = f.checks[k];
    fmt::format_to(std::back_inserter(out), "{}[{:.4g}", k > 0 ? "," : "", finite(c.ratio));
    if (c.value && c.bound)
      fmt::format_to(std::back_inserter(out), ",{:.4g},{:.4g}", finite(*c.value), finite(*c.bound));
    out.push_back(']');
  }
  out.push_back(']');
}

void put_movers(Out& out, const FrameFacts& f) {
  if (f.movers.empty()) return;
  put_text(out, ",\"mv\":[");
  for (std::size_t i = 0; i < f.movers.size(); ++i) {
    const MoverFact& m = f.movers[i];
    fmt::format_to(std::back_inserter(out), "{}[{},{},{:.3g},{:.3g},{:.5g},{:.5g},{:.5g},{:.5g}]", i > 0 ? "," : "",
                   m.id, m.of_vehicle ? 1 : 0, finite(m.speed_m_s), finite(m.centre_m.z()), finite(m.left_px),
                   finite(m.top_px), finite(m.right_px), finite(m.bottom_px));
  }
  out.push_back(']');
}

void put_times(Out& out, const FrameFacts& f) {
  const Durations& t = f.times;
  fmt::format_to(std::back_inserter(out), ",\"tm\":[{},{},{}],\"st\":[{},{},{},{},{}]", t.rectify_us, t.stereo_us,
                 t.odometry_us, t.steps_us[0], t.steps_us[1], t.steps_us[2], t.steps_us[3], t.steps_us[4]);
  if (f.latency_us > 0) put(out, "lt", f.latency_us);
}

}  // namespace

RigidTransform forward_left_up() {
  RigidTransform out;
  out.R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return out;
}

std::string to_json(const FrameFacts& f, std::int64_t number) {
  Out out;
  fmt::format_to(std::back_inserter(out), "{{\"n\":{},\"i\":{},\"t\":{},\"ep\":{},\"s\":{},\"q\":{}", number, f.index,
                 f.stamp_us, f.epoch, f.status, f.quality);
  put_pose(out, f);
  fmt::format_to(std::back_inserter(out), ",\"c\":[{},{},{},{}]", f.features, f.matches, f.clique, f.inliers);
  put(out, "sg", f.step_sigma_m, 4);
  put(out, "e", f.error_px, 7);
  put(out, "ee", f.expected_error_px, 4);
  put(out, "sh", f.shift_px, 4);
  const double check[] = {f.disparity_offset_px, f.disparity_offset_sigma_px, f.vertical_px, f.vertical_sigma_px};
  put_list(out, "sc", check, 4, 4);
  put(out, "fm", static_cast<std::int64_t>(f.failed));
  put_checks(out, f);
  put_times(out, f);
  if (f.truth_m) put_list(out, "tr", f.truth_m->data(), 3, 8);
  put_movers(out, f);
  if (!f.points.empty()) {
    put_text(out, ",\"pt\":[");
    for (std::size_t i = 0; i < f.points.size(); ++i) {
      const Eigen::Vector3f& p = f.points[i];
      fmt::format_to(std::back_inserter(out), "{}{:.2f},{:.2f},{:.2f}", i > 0 ? "," : "", p.x(), p.y(), p.z());
    }
    out.push_back(']');
  }
  out.push_back('}');
  return fmt::to_string(out);
}

Eigen::Matrix3d WayUncertainty::add(bool valid, const RigidTransform& T_world_camera, const Matrix6d& covariance) {
  if (!begun_) {
    begun_ = true;
    T_world_valid_ = T_world_camera;
    return Eigen::Matrix3d::Zero();
  }
  const Matrix6d A = adjoint(T_world_valid_);
  const Matrix6d now = sum_ + A * covariance * A.transpose();
  if (valid) {
    sum_ = now;
    T_world_valid_ = T_world_camera;
  }
  Eigen::Matrix<double, 3, 6> J;  // of the position, when all of the world is turned and shifted
  J << Eigen::Matrix3d::Identity(), -skew(T_world_camera.t);
  return J * now * J.transpose();
}

std::vector<Eigen::Vector3f> some_points(const std::vector<vo::SeenFeature>& features, std::size_t most,
                                         const StereoModel& model, const RigidTransform& T_world_camera) {
  std::vector<Eigen::Vector3f> out;
  const std::size_t step = std::max<std::size_t>(1, features.size() / (2 * most));
  constexpr double kFarthestBaselines = 250.0;  // beyond, a point is too uncertain
  for (std::size_t i = 0; i < features.size() && out.size() < most; i += step) {
    const vo::SeenFeature& f = features[i];
    if (f.role != vo::FeatureRole::inlier && f.role != vo::FeatureRole::of_key) continue;
    if (!(f.disparity_px + model.doffs_px > 0.0)) continue;
    const Eigen::Vector3d p = model.triangulate(f.x_px, f.y_px, f.disparity_px);
    if (!(p.z() < kFarthestBaselines * model.baseline_m)) continue;
    out.emplace_back((T_world_camera * p).cast<float>());
  }
  return out;
}

}  // namespace cliquevo::view
