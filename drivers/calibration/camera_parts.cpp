// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/calibration/camera_parts.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "drivers/calibration/lens_guess.h"

namespace cliquevo::drivers {

namespace {

bool all_zero(const std::vector<double>& v) {
  return std::all_of(v.begin(), v.end(), [](double x) { return x == 0.0; });
}

bool has_projection(const CameraParts& parts) { return parts.P.size() == 12 && !all_zero(parts.P); }

// A camera without a camera matrix, or without a rotation: of rectified images, where nothing bends.
Result<void> fill_from_projection(CameraParts& parts) {
  const bool straight = all_zero(parts.D);
  if (parts.camera.fx_px <= 0.0) {
    if (!straight) return calibration_error("camera matrix is singular (focal length <= 0)", parts.where);
    parts.camera.fx_px = parts.P[0];
    parts.camera.fy_px = parts.P[5];
    parts.camera.cx_px = parts.P[2];
    parts.camera.cy_px = parts.P[6];
  }
  if (!parts.R) {
    if (!straight) {
      return calibration_error("rectification is missing (R of zeros) though the lens has distortion", parts.where);
    }
    parts.R = Eigen::Matrix3d::Identity();
  }
  return {};
}

// Images that nothing bends and turns, with projections of unequal focal lengths or rows: two plain cameras.
bool is_plain_pair(const CameraParts& left, const CameraParts& right) {
  const auto straight = [](const CameraParts& parts) {
    return all_zero(parts.D) && (*parts.R - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-9;
  };
  const bool unequal = std::abs(left.P[0] - right.P[0]) > 1e-6 || std::abs(left.P[5] - right.P[5]) > 1e-6 ||
                       std::abs(left.P[6] - right.P[6]) > 1e-6;
  return straight(left) && straight(right) && unequal;
}

// Projections are of rectified images, whose rows and scale are one; some producers give each camera its own anyway.
void mend_projections(CameraParts& left, CameraParts& right, std::vector<std::string>& notes) {
  constexpr double kSmall = 0.015;
  if (!(std::abs(left.P[0] / right.P[0] - 1.0) < kSmall && std::abs(left.P[5] / right.P[5] - 1.0) < kSmall &&
        std::abs(left.P[6] - right.P[6]) < kSmall * left.P[5])) {
    return;
  }
  notes.push_back(
      fmt::format("projections of rectified images have unequal focal lengths ({:.2f} and {:.2f} px) or "
                  "rows: their means are taken",
                  left.P[0], right.P[0]));
  const double baseline_m = right.P[3] / right.P[0] - left.P[3] / left.P[0];
  for (const std::size_t i : {std::size_t{0}, std::size_t{5}, std::size_t{6}}) {
    left.P[i] = right.P[i] = 0.5 * (left.P[i] + right.P[i]);
  }
  left.P[3] = 0.0;
  right.P[3] = baseline_m * right.P[0];
}

Result<StereoCalibration> plain_pair(const CameraParts& left, const CameraParts& right, std::vector<std::string> notes,
                                     const CalibrationRequest& request, double unit_m) {
  StereoCalibration c;
  c.notes = std::move(notes);
  for (const CameraParts* parts : {&left, &right}) {
    CameraCalibration& camera = parts == &left ? c.left : c.right;
    camera = parts->camera;
    const std::vector<double>& P = parts->P;
    if (auto ok = set_camera_matrix({P[0], P[1], P[2], P[4], P[5], P[6], P[8], P[9], P[10]}, parts->where, camera);
        !ok) {
      return ok.error();
    }
    camera.distortion = Distortion::none;
  }
  c.T_right_left.t.x() = right.P[3] / right.P[0] - left.P[3] / left.P[0];
  return finish_calibration(c, request, unit_m);
}

}  // namespace

Result<void> put_camera_matrix(const std::vector<double>& K, const std::string& where, CameraParts& parts) {
  if (all_zero(K)) return {};
  return set_camera_matrix(K, where, parts.camera);
}

Result<void> put_rectification(const std::vector<double>& R, const std::string& where, CameraParts& parts) {
  if (all_zero(R)) return {};
  const Eigen::Matrix3d rotation = matrix3_from(R);
  if (auto ok = check_rotation(rotation, where); !ok) return ok;
  parts.R = rotation;
  return {};
}

Result<void> settle_lenses(CameraParts& left, CameraParts& right, const CalibrationOptions& options,
                           std::vector<std::string>& notes) {
  const bool unnamed = left.lens.empty() && right.lens.empty() && left.D.size() == 4 && right.D.size() == 4;
  if (unnamed && !options.lens.empty()) {
    left.lens = right.lens = options.lens;
  } else if (unnamed) {
    const LensGuess guess = guess_lens(left.camera, left.D, right.camera, right.D);
    if (guess.lens.empty()) return lens_question(left.D_where);
    if (!guess.note.empty()) notes.push_back(guess.note + " (" + left.D_where + ")");
    left.lens = right.lens = guess.lens;
  }
  for (CameraParts* parts : {&left, &right}) {
    if (auto ok = set_distortion(parts->lens, parts->D, parts->D_where, parts->camera); !ok) return ok;
  }
  return {};
}

Result<StereoCalibration> rig_of_projections(CameraParts left, CameraParts right,
                                             const std::optional<Eigen::Vector3d>& T, const CalibrationRequest& request,
                                             double unit_m) {
  for (CameraParts* parts : {&left, &right}) {
    if (!has_projection(*parts)) {
      return calibration_error("projection is all zeros: it holds no baseline", parts->where);
    }
    if (parts->P[0] <= 0.0 || parts->P[5] <= 0.0) {
      return calibration_error("projection is singular (focal length <= 0)", parts->where);
    }
    if (auto ok = fill_from_projection(*parts); !ok) return ok.error();
  }
  StereoCalibration c;
  if (auto ok = settle_lenses(left, right, request.options, c.notes); !ok) return ok.error();
  left.P[3] *= unit_m;
  right.P[3] *= unit_m;
  // Some drivers leave the baseline out of P and give T (left -> right) instead.
  if (left.P[3] == 0.0 && right.P[3] == 0.0) {
    if (!T) return calibration_error("baseline is zero (P of the right camera has no fx * Tx)", right.where);
    right.P[3] = (T->x() < 0.0 ? -1.0 : 1.0) * right.P[0] * T->norm();
  }
  if (is_plain_pair(left, right)) {
    mend_projections(left, right, c.notes);
    return plain_pair(left, right, std::move(c.notes), request, unit_m);
  }
  const Result<StereoModel> model = model_from_projections(left.P, right.P, right.where + " (projection matrix)");
  if (!model) return model.error();
  c.left = left.camera;
  c.right = right.camera;
  // In the rectified frames the cameras differ by the baseline alone.
  c.T_right_left.R = right.R->transpose() * *left.R;
  c.T_right_left.t = right.R->transpose() * Eigen::Vector3d(-model->baseline_m, 0.0, 0.0);
  c.prescribed = PrescribedRectification{*left.R, *right.R, *model};
  return finish_calibration(c, request, unit_m);
}

Result<StereoCalibration> rig_of_pose(CameraParts left, CameraParts right, const RigidTransform& T_right_left,
                                      const CalibrationRequest& request, double unit_m) {
  StereoCalibration c;
  if (auto ok = settle_lenses(left, right, request.options, c.notes); !ok) return ok.error();
  c.left = left.camera;
  c.right = right.camera;
  c.T_right_left = T_right_left;
  c.T_right_left.t *= unit_m;
  if (left.R && right.R && has_projection(left) && has_projection(right)) {
    Result<StereoModel> model = model_from_projections(left.P, right.P, right.where + " (projection matrix)");
    if (!model) return model.error();
    model->baseline_m *= unit_m;
    c.prescribed = PrescribedRectification{*left.R, *right.R, *model};
  }
  return finish_calibration(c, request, unit_m);
}

}  // namespace cliquevo::drivers
