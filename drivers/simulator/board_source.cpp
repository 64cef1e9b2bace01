// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/simulator/board_source.h"

#include <limits>
#include <utility>

#include <Eigen/LU>
#include <fmt/format.h>

#include "drivers/simulator/board_course.h"
#include "drivers/simulator/board_view.h"
#include "drivers/simulator/fault.h"
#include "drivers/simulator/photograph.h"
#include "drivers/simulator/renderer.h"
#include "drivers/simulator/sensor.h"

namespace cliquevo::drivers::sim {

namespace {

// The cameras stand still, and their rows are read when the board's are: the rest is as for every camera.
SimulatorOptions of_still_cameras(SimulatorOptions o) {
  o.course = "standing";
  o.readout_ms = 0.0;
  o.sway_deg = 0.0;
  return o;
}

class MovedBoard : public BoardSimulator {
 public:
  MovedBoard(const SimulatorOptions& options, BoardPattern pattern, BoardCourse board, StereoCalibration rig)
      : options_(options),
        still_(of_still_cameras(options)),
        course_(still_),
        pattern_(std::move(pattern)),
        board_(std::move(board)),
        left_(pattern_, rig.left, RigidTransform{}, options.world_seed),
        right_(pattern_, rig.right, rig.T_right_left.inverse(), options.world_seed),
        shutter_{options.motion_blur ? kExposureS : 0.0, 1e-3 * std::max(options.readout_ms, 0.0)} {
    info_.width = options.width;
    info_.height = options.height;
    info_.rate_hz = options.rate_hz / static_cast<double>(options.every);
    info_.frame_count = (options.frames + options.every - 1) / options.every;
    info_.description = fmt::format("simulator, {} before a {}rig, noise {}", pattern_.board().text(),
                                    rig.rectified ? "rectified " : "", options.noise_seed);
    info_.calibration = std::move(rig);
  }

  const SourceInfo& info() const override { return info_; }

  Result<bool> next(StereoPair& pair) override {
    if (next_ >= info_.frame_count) return false;
    const std::int64_t frame = next_ * options_.every;
    pair.index = next_++;
    pair.stamp_ns = stamp_of(options_, frame);
    pair.right_offset_ns = static_cast<std::int64_t>(1e6 * options_.skew_ms);
    pair.truth_T_world_camera = RigidTransform{};
    for (const int camera : {0, 1}) {
      const double middle_s = time_of(camera, delivered_frame(options_, frame, camera));
      const PoseAt pose = [&](double later_s) { return T_camera_board(camera, middle_s + later_s); };
      (camera == 0 ? left_ : right_).render(pose, shutter_, clean_);
      Image<std::uint8_t>& out = camera == 0 ? pair.left : pair.right;
      if (auto ok = photograph(still_, course_, frame, camera, clean_.cview(), rough_, out); !ok) return ok.error();
    }
    return true;
  }

  RigidTransform truth_T_left_board() const override { return T_camera_board(0, time_of(0, last_frame())); }
  RigidTransform truth_T_right_board() const override { return T_camera_board(1, time_of(1, last_frame())); }

  ImageView<const float> truth_disparity() const override {
    if (next_ == 0 || !info_.calibration.prescribed) return {};
    const PrescribedRectification& rectified = *info_.calibration.prescribed;
    const StereoModel& m = rectified.model;
    const RigidTransform T = truth_T_left_board();
    Eigen::Matrix3d from_board;
    from_board << T.R.col(0), T.R.col(1), T.t;
    const Eigen::Matrix3d to_board = from_board.inverse();
    truth_.resize(m.width, m.height);
    for (int j = 0; j < m.height; ++j) {
      for (int i = 0; i < m.width; ++i) {
        const Eigen::Vector3d pinhole((i - m.cx_px) / m.fx_px, (j - m.cy_px) / m.fy_px, 1.0);
        const Eigen::Vector3d ray = rectified.R_left.transpose() * pinhole;  // z of the rectified camera is 1
        const Eigen::Vector3d p = to_board * ray;
        const bool on_board = p.z() > 0.0 && pattern_.at(p.x() / p.z(), p.y() / p.z()).ink != BoardPattern::Ink::none;
        const double z = on_board ? 1.0 / p.z() : to_wall(Eigen::Vector3d::Zero(), ray.normalized()) / ray.norm();
        truth_.view()(i, j) = static_cast<float>(m.fx_px * m.baseline_m / z - m.doffs_px);
      }
    }
    return truth_.cview();
  }
  CameraShake truth_shake() const override {
    return next_ == 0 ? CameraShake{} : shake_of(options_, delivered_frame(options_, last_frame(), 1));
  }

 private:
  std::int64_t last_frame() const { return std::max<std::int64_t>(next_ - 1, 0) * options_.every; }
  double time_of(int camera, std::int64_t frame) const {
    return static_cast<double>(frame) / options_.rate_hz + (camera == 1 ? 1e-3 * options_.skew_ms : 0.0);
  }
  RigidTransform T_camera_board(int camera, double time_s) const {
    const RigidTransform T = board_.T_left_board(time_s);
    return camera == 0 ? T : info_.calibration.T_right_left * T;
  }

  const SimulatorOptions options_, still_;
  const Course course_;
  const BoardPattern pattern_;
  const BoardCourse board_;
  const BoardView left_, right_;
  const BoardView::Shutter shutter_;
  SourceInfo info_;
  std::int64_t next_ = 0;
  Image<std::uint16_t> clean_;
  RoughScratch rough_;
  mutable Image<float> truth_;
};

}  // namespace

Result<std::unique_ptr<Simulator>> open_board(const SimulatorOptions& options) {
  const auto board = calibration::parse_board(options.board);
  if (!board) return board.error();
  auto pattern = BoardPattern::make(*board);
  if (!pattern) return pattern.error();
  StereoCalibration rig = board_rig(options);
  auto course = BoardCourse::make(options, *pattern, rig);
  if (!course) return course.error();
  return std::unique_ptr<Simulator>(
      std::make_unique<MovedBoard>(options, std::move(*pattern), std::move(*course), std::move(rig)));
}

}  // namespace cliquevo::drivers::sim
