// SPDX-License-Identifier: BSD-3-Clause
#include "tools/calibrate/from_driving.h"

#include <cmath>

#include <fmt/format.h>

#include "daemon/pipeline/frame_pipeline.h"
#include "stereo/rectification.h"
#include "tools/progress.h"
#include "tools/skipped_pairs.h"
#include "tools/stop_on_signal.h"

namespace cliquevo::tools {

namespace {

constexpr double kRadian = M_PI / 180.0;
constexpr int kMostRounds = 4;
constexpr int kLeastFrames = 50;            // that contributed to the self-check
constexpr double kLeastCertain_deg = 0.02;  // about x and z, which rows alone show
constexpr double kClear = 3.0;              // standard deviations from which on an axis is corrected
constexpr double kClearFocal = 4.0;         // likewise the right focal length, which a tilted baseline may pretend,
constexpr double kLeastFocal = 5e-4;        // and only by so much of it

// A source's description with another calibration.
drivers::SourceInfo described(const drivers::SourceInfo& info, const StereoCalibration& calibration) {
  drivers::SourceInfo out;
  out.description = info.description;
  out.width = info.width;
  out.height = info.height;
  out.frame_count = info.frame_count;
  out.rate_hz = info.rate_hz;
  out.first_number = info.first_number;
  out.live = info.live;
  out.calibration = calibration;
  if (!info.left_mask.empty()) out.left_mask.copy_from(info.left_mask.cview());
  if (!info.right_mask.empty()) out.right_mask.copy_from(info.right_mask.cview());
  return out;
}

Result<DrivenRun> drive(drivers::FrameSource& source, const StereoCalibration& calibration,
                        const daemon::Config& config, int round) {
  daemon::PipelineParams params;
  params.stereo = config.stereo;
  params.odometry = config.odometry;
  auto pipeline = daemon::FramePipeline::make(params, described(source.info(), calibration));
  if (!pipeline) return pipeline.error();
  DrivenRun run;
  RigidTransform last_pose;
  std::optional<RigidTransform> first_truth, last_truth;
  double error_px = 0.0;
  drivers::StereoPair pair;
  SkippedPairs skipped;
  Progress progress(source.info().frame_count);
  while (!StopOnSignal::received()) {
    const auto more = source.next(pair);
    if (!more) {
      skipped.add(pair.index, more.error());
      if (skipped.count() > std::max<std::int64_t>(1000, source.info().frame_count)) return more.error();
      continue;
    }
    if (!*more) break;
    if (auto ok = pipeline->process(pair); !ok) return ok.error();
    const vo::Estimate& e = pipeline->estimate();
    ++run.frames;
    if (e.status == vo::Status::valid) {
      ++run.valid;
      error_px += e.reprojection_error_px;
      run.way_m += e.T_prev_cur.t.norm();
    }
    run.check = e.calibration;
    last_pose = e.T_world_camera;
    if (pair.truth_T_world_camera) {
      if (!first_truth) first_truth = pair.truth_T_world_camera;
      last_truth = pair.truth_T_world_camera;
    }
    progress.update(run.frames, run.way_m, fmt::format("run {}", round + 1));
  }
  progress.finish();
  run.reprojection_px = run.valid > 0 ? error_px / static_cast<double>(run.valid) : 0.0;
  if (first_truth && run.way_m > 0.0) {
    const RigidTransform truth = first_truth->inverse() * *last_truth;
    run.end_error_percent = 100.0 * (truth.t - last_pose.t).norm() / run.way_m;
  }
  return run;
}

// What is clear of the turn that the run shows; the other axes 0.
Eigen::Vector3d clear_turn_deg(const vo::CalibrationCheck& check) {
  Eigen::Vector3d out = Eigen::Vector3d::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    if (std::abs(check.rotation_deg(axis)) > kClear * check.rotation_sigma_deg(axis))
      out(axis) = check.rotation_deg(axis);
  }
  return out;
}

// What is clear of the right camera's focal length over what the calibration has, less 1.
double clear_focal_error(const vo::CalibrationCheck& check) {
  const double error = check.focal_ratio_error;
  return std::abs(error) > std::max(kLeastFocal, kClearFocal * check.focal_ratio_sigma) ? error : 0.0;
}

Result<void> check_evidence(const DrivenRun& run) {
  const vo::CalibrationCheck& c = run.check;
  const double least_certain = std::max(c.rotation_sigma_deg.x(), c.rotation_sigma_deg.z());
  if (c.frames >= kLeastFrames && least_certain <= kLeastCertain_deg) return {};
  return Error{
      "the drive shows too little to correct a calibration",
      fmt::format("{} of {} frames contributed, rotation known to {:.3f} degrees", c.frames, run.frames, least_certain),
      "drive farther, through a scene with texture in all parts of the image"};
}

CameraCalibration pinhole_of(const StereoModel& m, double cx_px) {
  CameraCalibration c;
  c.width = m.width;
  c.height = m.height;
  c.fx_px = m.fx_px;
  c.fy_px = m.fy_px;
  c.cx_px = cx_px;
  c.cy_px = m.cy_px;
  return c;
}

}  // namespace

StereoCalibration with_right_camera_turned(const StereoCalibration& calibration, const Eigen::Vector3d& turn_rad) {
  StereoCalibration out = calibration;
  Eigen::Matrix3d R_rectified_right = Eigen::Matrix3d::Identity();
  if (calibration.rectified && calibration.prescribed) {
    const StereoModel& m = calibration.prescribed->model;
    out.left = pinhole_of(m, m.cx_px);
    out.right = pinhole_of(m, m.cx_px + m.doffs_px);
    out.T_right_left = {Eigen::Matrix3d::Identity(), {-m.baseline_m, 0.0, 0.0}};
  } else if (const auto rectification = stereo::choose_rectification(calibration)) {
    R_rectified_right = rectification->R_right;
  }
  const Eigen::Matrix3d turn = R_rectified_right.transpose() * so3_exp(turn_rad) * R_rectified_right;
  out.T_right_left = RigidTransform{turn, Eigen::Vector3d::Zero()} * out.T_right_left;
  out.rectified = false;
  out.prescribed.reset();
  return out;
}

StereoCalibration with_right_focal_scaled(const StereoCalibration& calibration, double ratio) {
  StereoCalibration out = with_right_camera_turned(calibration, Eigen::Vector3d::Zero());
  out.right.fx_px *= ratio;
  out.right.fy_px *= ratio;
  return out;
}

Result<DrivenCalibration> calibrate_from_driving(const OpenSource& open, const daemon::Config& config) {
  DrivenCalibration out;
  for (int round = 0; round < kMostRounds && !StopOnSignal::received(); ++round) {
    auto source = open();
    if (!source) return source.error();
    if (round == 0) out.calibration = (*source)->info().calibration;
    auto run = drive(**source, out.calibration, config, round);
    if (!run) return run.error();
    out.runs.push_back(*run);
    if (auto ok = check_evidence(*run); !ok) return ok.error();
    out.sigma_deg = run->check.rotation_sigma_deg;
    out.focal_ratio_sigma = run->check.focal_ratio_sigma;
    const Eigen::Vector3d turn_deg = clear_turn_deg(run->check);
    const double focal_error = clear_focal_error(run->check);
    const bool last = round + 1 == kMostRounds;
    const bool nothing_left = turn_deg.isZero() && focal_error == 0.0;
    if (nothing_left || last || (round == 0 && !run->check.noticeable())) break;
    // What is there is what the calibration lacks: rectifying takes it back.
    out.calibration = with_right_camera_turned(out.calibration, -kRadian * turn_deg);
    if (focal_error != 0.0) out.calibration = with_right_focal_scaled(out.calibration, 1.0 + focal_error);
    out.turned_deg += turn_deg;
    out.focal_ratio *= 1.0 + focal_error;
    out.changed = true;
  }
  return out;
}

}  // namespace cliquevo::tools
