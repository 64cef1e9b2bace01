// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view/pipeline_feed.h"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "daemon/lcm/odometry_builder.h"
#include "daemon/lcm/points.h"
#include "tools/view/ros2_writer.h"

namespace cliquevo::view {

namespace {

constexpr std::size_t kDrawnPoints = 10;
constexpr double kPointsHz = 5.0;
constexpr int kPointsStep_px = 4;

MoverFact fact_of(const vo::Mover& m) {
  MoverFact out;
  out.id = m.id;
  out.of_vehicle = m.of_vehicle;
  out.centre_m = m.centre;
  out.speed_m_s = m.velocity_m_s.norm();
  for (int i = 0; i < m.points; ++i) {
    const vo::MoverPoint& p = m.point[static_cast<std::size_t>(i)];
    out.left_px = i == 0 ? p.x_px : std::min(out.left_px, static_cast<double>(p.x_px));
    out.top_px = i == 0 ? p.y_px : std::min(out.top_px, static_cast<double>(p.y_px));
    out.right_px = i == 0 ? p.x_px : std::max(out.right_px, static_cast<double>(p.x_px));
    out.bottom_px = i == 0 ? p.y_px : std::max(out.bottom_px, static_cast<double>(p.y_px));
  }
  return out;
}

FrameFacts facts_of(const daemon::FramePipeline& pipeline, std::int64_t index, const RigidTransform& T_body_camera) {
  const vo::Estimate& e = pipeline.estimate();
  const daemon::StageTimes& t = pipeline.times();
  FrameFacts out;
  out.index = index;
  out.stamp_us = e.stamp_ns / 1000;
  out.status = static_cast<int>(e.status);
  out.quality = e.quality;
  out.T_world_body = T_body_camera * e.T_world_camera * T_body_camera.inverse();
  out.step_sigma_m = std::sqrt(std::max(0.0, e.covariance.topLeftCorner<3, 3>().trace()));
  out.features = e.features;
  out.matches = e.matches;
  out.clique = e.clique;
  out.inliers = e.inliers;
  out.error_px = e.reprojection_error_px;
  out.expected_error_px = e.expected_error_px;
  out.shift_px = e.disparity_shift_px;
  out.disparity_offset_px = e.calibration.disparity_offset_px;
  out.disparity_offset_sigma_px = e.calibration.disparity_offset_sigma_px;
  out.vertical_px = e.calibration.vertical_px;
  out.vertical_sigma_px = e.calibration.vertical_sigma_px;
  for (std::size_t k = 0; k < vo::kChecks; ++k) {
    const vo::Evidence& evidence = e.checks[static_cast<vo::Check>(k)];
    if (evidence.applies) out.checks[k] = {evidence.ratio(), evidence.value, evidence.bound};
  }
  out.failed = e.checks.failed();
  out.times = {t.rectify_ns / 1000,
               t.stereo_ns / 1000,
               t.odometry_ns / 1000,
               {e.times.features_ns / 1000, e.times.scores_ns / 1000, e.times.matches_ns / 1000,
                e.times.clique_ns / 1000, e.times.motion_ns / 1000}};
  const vo::Movers& movers = pipeline.movers();
  for (int k = 0; k < movers.count; ++k) out.movers.push_back(fact_of(movers.mover[static_cast<std::size_t>(k)]));
  return out;
}

class PipelineFeed final : public Feed {
 public:
  PipelineFeed(std::unique_ptr<drivers::FrameSource> source, daemon::FramePipeline pipeline,
               const std::optional<RigidTransform>& T_body_camera)
      : source_(std::move(source)),
        pipeline_(std::move(pipeline)),
        T_body_camera_(T_body_camera.value_or(forward_left_up())),
        facts_(T_body_camera_),
        odometry_(T_body_camera_),
        tap_({.width = pipeline_.model().width, .height = pipeline_.model().height, .rate_hz = kPointsHz}) {
    state_.level = T_body_camera.has_value();
    state_.frames = source_->info().frame_count;
    state_.text = "processing";
    state_.model = pipeline_.model();
    if (!pipeline_.mask().empty()) {
      state_.mask = std::make_shared<const Bytes>(jpeg_.encode(pipeline_.mask(), kMaskQuality));
    }
  }

  bool live() const override { return false; }
  std::string source() const override { return source_->info().description; }
  FeedState state() const override {
    const std::lock_guard lock(mutex_);
    return state_;
  }

  void run(Store& store, Ros2Topics& topics, const std::function<bool()>& stopped) override {
    ros2_.emplace(topics, T_body_camera_);
    drivers::StereoPair pair;
    int in_a_row = 0;  // pairs that cannot be read
    while (!stopped()) {
      const Result<bool> read = source_->next(pair);
      if (!read) {
        if (++in_a_row > 1000) return end(read.error().line());
        continue;
      }
      in_a_row = 0;
      if (!*read) return end({});
      if (auto done = pipeline_.process(pair); !done) return end(done.error().line());
      add(pair, store);
      add_ros2(pair.stamp_ns);
    }
  }

 private:
  void add(const drivers::StereoPair& pair, Store& store) {
    const FrameFacts facts = facts_.make(pipeline_, pair);
    const vo::Estimate& e = pipeline_.estimate();
    FrameParts parts;
    parts.features = pack_features(facts_.features());
    parts.left = jpeg_.encode(pipeline_.rectified_left(), kJpegQuality);
    parts.right = jpeg_.encode(pipeline_.rectified_right(), kJpegQuality);
    DisparityPicture disparity = encode_disparity(pipeline_.disparity());
    parts.disparity = std::move(disparity.png);
    parts.disparity_step_px = disparity.step_px;
    store.add(facts, parts);
    const std::string finding = source_->finding();
    const std::lock_guard lock(mutex_);
    state_.check_text = finding.empty() ? vo::describe(e.calibration) : finding;
    state_.view_text = vo::describe(e.vehicle_part);
  }

  void add_ros2(TimestampNs stamp_ns) {
    daemon::PublishedFrame frame;
    frame.estimate = pipeline_.estimate();
    const bool usable = frame.estimate.T_prev_cur.is_finite() && frame.estimate.T_world_camera.is_finite();
    odometry_.build(frame, usable, stamp_ns, message_);
    ros2_->add(message_);
    ros2_->add_left(stamp_ns, pipeline_.rectified_left(), pipeline_.model());
    ros2_->add_disparity(stamp_ns, pipeline_.disparity());
    if (!ros2_->wants_points()) return;
    tap_.offer(stamp_ns, pipeline_.rectified_left(), {}, pipeline_.disparity());
    if (tap_.take() == nullptr) return;
    daemon::build_points(*tap_.take(), pipeline_.model(), T_body_camera_, kPointsStep_px, points_);
    tap_.give_back();
    ros2_->add(points_);
  }

  void end(const std::string& error) {
    const std::lock_guard lock(mutex_);
    state_.done = true;
    state_.error = error;
    state_.text = error.empty() ? "all frames are there" : "ended early";
  }

  std::unique_ptr<drivers::FrameSource> source_;
  daemon::FramePipeline pipeline_;
  JpegEncoder jpeg_;
  const RigidTransform T_body_camera_;
  FactsMaker facts_;
  std::optional<Ros2Writer> ros2_;  // once it runs
  daemon::OdometryBuilder odometry_;
  odometry_t message_{};
  daemon::ImageTap tap_;
  points_t points_{};
  mutable std::mutex mutex_;
  FeedState state_;
};

}  // namespace

FrameFacts FactsMaker::make(const daemon::FramePipeline& pipeline, const drivers::StereoPair& pair) {
  FrameFacts facts = facts_of(pipeline, pair.index, T_body_camera_);
  const vo::Estimate& e = pipeline.estimate();
  const RigidTransform T_world_camera = T_body_camera_ * e.T_world_camera;
  facts.position_m2 = way_.add(e.status == vo::Status::valid, T_world_camera, e.covariance);
  if (pair.truth_T_world_camera) {
    // They begin where the reference does.
    if (!T_first_world_) T_first_world_ = e.T_world_camera * pair.truth_T_world_camera->inverse();
    facts.truth_m = (T_body_camera_ * (*T_first_world_ * *pair.truth_T_world_camera) * T_body_camera_.inverse()).t;
  }
  pipeline.list_features(features_);
  if (count_++ % 3 == 0 && e.status == vo::Status::valid) {
    facts.points = some_points(features_, kDrawnPoints, pipeline.model(), T_world_camera);
  }
  return facts;
}

std::unique_ptr<Feed> make_pipeline_feed(std::unique_ptr<drivers::FrameSource> source, daemon::FramePipeline pipeline,
                                         const std::optional<RigidTransform>& T_body_camera) {
  return std::make_unique<PipelineFeed>(std::move(source), std::move(pipeline), T_body_camera);
}

}  // namespace cliquevo::view
