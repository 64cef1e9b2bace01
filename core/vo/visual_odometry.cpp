// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/visual_odometry.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>
#include <vector>

#include "core/vo/estimator.h"
#include "core/vo/mover_tracker.h"

namespace cliquevo::vo {

const char* status_name(Status status) {
  switch (status) {
    case Status::no_data:
      return "no data";
    case Status::valid:
      return "valid";
    case Status::too_few_features:
      return "too few features";
    case Status::degenerate:
      return "degenerate";
    case Status::reprojection_error:
      return "reprojection error";
    case Status::ambiguous:
      return "ambiguous";
  }
  return "unknown";
}

namespace {
constexpr double kPi = 3.14159265358979323846;
constexpr double kSpeed_m_s = 5.0;  // of a vehicle of which nothing is known yet
// Where nothing is known of the speed: straight ahead at these.
constexpr double kSpeeds_m_s[] = {0.0, 8.0, 14.0, 20.0, 26.0, 32.0, 38.0};
constexpr double kTurn_rad_s = 0.25;  // what a vehicle that drove straight may do next
}  // namespace

// After a doubtful frame the next must be the clearer: until one is valid where the ground was seen to run, for some
// frames only where a part of the picture moved otherwise, as among people there is always some.
struct Wariness {
  static constexpr int kFrames = 3;
  bool of_running_ground = false;
  int frames = 0;  // to come
  bool any() const { return of_running_ground || frames > 0; }
  void learn(const Comparison& c) {
    if (c.unsteady) of_running_ground = true;
    if (c.contradicted) frames = kFrames + 1;
  }
  void next(bool valid) {
    frames = valid ? 0 : std::max(0, frames - 1);
    if (valid) of_running_ground = false;
  }
};

struct VisualOdometry::Impl {
  Impl(const StereoModel& model_, const VoParams& params_)
      : model(model_),
        params(params_),
        detector(model_, params_),
        tracker(model_, params_),
        estimator(model_, params_),
        self_check(model_, params_),
        mover_tracker(model_, params_) {
    for (int i = 0; i < 4; ++i) {
      frames.emplace_back(std::make_unique<Frame>(params));
      frames.back()->left.resize(model.width, model.height);
      frames.back()->right.resize(model.width, model.height);
    }
  }

  Result<void> check(const FrameInput& input) const;
  void load(const FrameInput& input);
  void accept(const Comparison& comparison, const Frame& reference);
  void carry_on();
  RigidTransform prediction(const Frame& since) const;
  std::span<const RigidTransform> predictions(const Frame& since);
  Frame* spare();

  StereoModel model;
  VoParams params;
  FeatureDetector detector;
  Tracker tracker;
  Estimator estimator;
  SelfCheck self_check;
  MoverTracker mover_tracker;
  Image<std::uint8_t> mask;
  std::vector<std::unique_ptr<Frame>> frames;
  Frame* current = nullptr;
  Frame* valid = nullptr;   // last frame with a valid estimate (or the first one)
  Frame* key = nullptr;     // kept reference
  Frame* failed = nullptr;  // last frame, where its estimate failed
  Wariness wary;
  Matrix6d valid_covariance = Matrix6d::Zero();  // of its motion against the references it had
  std::array<RigidTransform, std::size(kSpeeds_m_s)> predicted;
  RigidTransform velocity;      // motion over the last valid interval ...
  TimestampNs velocity_ns = 0;  // ... and its length
  Matrix6d guess_covariance = Matrix6d::Zero();
  Estimate estimate;
};

Result<void> VisualOdometry::Impl::check(const FrameInput& input) const {
  const auto fits = [&](const auto& view) { return !view.empty() && view.same_size(model.width, model.height); };
  if (!fits(input.left) || !fits(input.right) || !fits(input.filtered_left) || !fits(input.disparity)) {
    return Error{"unusable frame", "an image is empty or not of the calibration's size",
                 "hand over left, right, filtered and disparity images of the stereo model's size"};
  }
  const TimestampNs last_ns =
      failed != nullptr ? failed->stamp_ns : (valid != nullptr ? valid->stamp_ns : input.stamp_ns - 1);
  if (input.stamp_ns <= last_ns) {
    return Error{"unusable frame", "its time stamp does not advance",
                 "hand over frames in the order of their exposure"};
  }
  return {};
}

// Step A2: features of the new frame, their depth and descriptors.
void VisualOdometry::Impl::load(const FrameInput& input) {
  current = spare();
  current->stamp_ns = input.stamp_ns;
  current->left.copy_from(input.left);
  current->right.copy_from(input.right);
  detector.detect(params.corner_image == CornerImage::filtered ? input.filtered_left : input.left, input.disparity,
                  mask.cview(), self_check.disparity_error_px(model.cx_px, model.cy_px), current->features);
  current->descriptors.extract(input.filtered_left, current->features, params.descriptor_window);
  if (params.refine) {
    tracker.refine_disparities(input.disparity, self_check, *current);
    estimator.prepare(input.disparity, *current);
  }
}

Frame* VisualOdometry::Impl::spare() {
  for (const auto& frame : frames) {
    if (frame.get() != valid && frame.get() != key && frame.get() != failed) return frame.get();
  }
  return nullptr;  // four frames serve three roles: one is always free
}

void VisualOdometry::Impl::accept(const Comparison& c, const Frame& reference) {
  const RigidTransform T_valid_ref = valid->T_world_camera.inverse() * reference.T_world_camera;
  current->T_world_camera = (reference.T_world_camera * c.motion.T_prev_cur).normalized();
  estimate.T_prev_cur = T_valid_ref * c.motion.T_prev_cur;
  estimate.covariance = c.motion.covariance;
  if (key != nullptr && key != valid && &reference == valid) {
    // The key frame tells where the current frame is better than it was known where the previous one is: then the
    // motion between them takes back the latter's error.
    const Matrix6d A = adjoint(velocity.inverse());
    const Matrix6d before = A * valid_covariance * A.transpose();
    const double excess = 1.0 - (c.motion.covariance.diagonal().array() / before.diagonal().array()).mean();
    if (excess > 0.0) estimate.covariance += excess * before;
  }
  valid_covariance = c.motion.covariance;
  if (&reference != valid) {
    const Matrix6d A = adjoint(T_valid_ref);
    estimate.covariance = guess_covariance + A * c.motion.covariance * A.transpose();
  }
  estimate.status = Status::valid;
  velocity = estimate.T_prev_cur;
  velocity_ns = current->stamp_ns - valid->stamp_ns;
  const bool lost_overlap = !params.use_key_frame || c.key_overlap < params.key_frame_overlap;
  if (lost_overlap || &reference != valid) key = current;
  valid = current;
  failed = nullptr;
}

// Constant velocity from an earlier frame to the current one: a guess.
RigidTransform VisualOdometry::Impl::prediction(const Frame& since) const {
  RigidTransform step;
  if (velocity_ns > 0) {
    const double share = static_cast<double>(current->stamp_ns - since.stamp_ns) / static_cast<double>(velocity_ns);
    step.R = so3_exp(share * so3_log(velocity.R));
    step.t = share * velocity.t;
  }
  return step;
}

// Where to look: there, or wherever it may be as long as no speed is known.
std::span<const RigidTransform> VisualOdometry::Impl::predictions(const Frame& since) {
  predicted.fill(prediction(since));
  if (velocity_ns > 0) return {predicted.data(), 1};
  const double elapsed_s = static_cast<double>(current->stamp_ns - since.stamp_ns) * 1e-9;
  for (std::size_t k = 0; k < predicted.size(); ++k) predicted[k].t.z() = kSpeeds_m_s[k] * elapsed_s;
  return predicted;
}

// A failed frame: the pose moves on by the stated guess, and the next attempt may start from here.
void VisualOdometry::Impl::carry_on() {
  const Frame& last = failed != nullptr ? *failed : *valid;
  const RigidTransform step = params.after_failure == AfterFailure::hold ? RigidTransform{} : prediction(last);
  current->T_world_camera = (last.T_world_camera * step).normalized();
  // As uncertain as if the vehicle had stopped, or gone twice as fast, or begun to turn.
  const double elapsed_s = static_cast<double>(current->stamp_ns - last.stamp_ns) * 1e-9;
  const double unknown = velocity_ns > 0 ? 0.0 : kSpeed_m_s * elapsed_s;
  const double moved = std::max({0.05, step.t.norm(), unknown});
  const double turned = std::max({0.01, step.angle(), std::min(kPi, kTurn_rad_s * elapsed_s)});
  Vector6d variance;
  variance << Eigen::Vector3d::Constant(moved * moved), Eigen::Vector3d::Constant(turned * turned);
  if (failed == nullptr) guess_covariance.setZero();
  guess_covariance.diagonal() += variance;
  estimate.T_prev_cur = {};
  estimate.covariance = guess_covariance;
  failed = current;
}

Result<VisualOdometry> VisualOdometry::make(const StereoModel& model, const VoParams& params) {
  if (auto ok = model.check(); !ok) return ok.error();
  if (auto ok = params.check(); !ok) return ok.error();
  return VisualOdometry(std::make_unique<Impl>(model, params));
}

VisualOdometry::VisualOdometry(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VisualOdometry::VisualOdometry(VisualOdometry&&) noexcept = default;
VisualOdometry& VisualOdometry::operator=(VisualOdometry&&) noexcept = default;
VisualOdometry::~VisualOdometry() = default;

Result<void> VisualOdometry::set_mask(ImageView<const std::uint8_t> left_mask) {
  if (left_mask.empty()) {
    impl_->mask = {};
  } else if (left_mask.same_size(impl_->model.width, impl_->model.height)) {
    impl_->mask.copy_from(left_mask);
  } else {
    return Error{"unusable mask", "its size is not the rectified image's", "rectify the mask with the images"};
  }
  return {};
}

Result<void> VisualOdometry::process(const FrameInput& input) {
  Impl& s = *impl_;
  if (auto ok = s.check(input); !ok) return ok;
  const std::int64_t start_ns = monotonic_ns();
  Estimate& e = s.estimate;
  e = {};
  s.load(input);
  e.stamp_ns = input.stamp_ns;
  e.features = static_cast<int>(s.current->features.size());
  e.times.features_ns = monotonic_ns() - start_ns;
  if (s.valid == nullptr) {
    e.prev_stamp_ns = input.stamp_ns;
    s.current->T_world_camera = {};
    s.valid = s.key = s.current;
    s.mover_tracker.skip(*s.current);
  } else {
    e.prev_stamp_ns = s.valid->stamp_ns;
    const Frame* reference = s.valid;
    for (Frame* frame : {s.valid, s.key, s.failed}) {
      if (frame != nullptr && s.params.refine) s.tracker.compensate(s.self_check, *frame);
    }
    Comparison c = s.estimator.compare(*reference, s.key, *s.current, input.disparity, s.predictions(*reference),
                                       s.self_check, s.wary.any(), e.times);
    s.wary.learn(c);
    if (c.status != Status::valid && s.failed != nullptr) {
      reference = s.failed;
      c = s.estimator.compare(*reference, nullptr, *s.current, input.disparity, s.predictions(*reference), s.self_check,
                              s.wary.any(), e.times);
      s.wary.learn(c);
    }
    s.wary.next(c.status == Status::valid);
    e.status = c.status;
    e.matches = c.matches;
    e.clique = c.clique;
    e.inliers = c.motion.inliers;
    e.reprojection_error_px = c.motion.error_px;
    e.eigenvalue_ratio = c.eigenvalue_ratio;
    e.contradiction = c.contradiction;
    e.unsteadiness_px = c.unsteadiness_px;
    e.disparity_offset_px = c.motion.offset_px;
    e.disparity_offset_information = c.motion.offset_information;
    if (c.status == Status::valid) {
      if (s.params.refine) {
        s.self_check.add_offset(c.motion.offset_px, c.motion.offset_information);
        const Vector6d& change = c.motion.offset_sensitivity;
        c.motion.covariance *= s.self_check.unsettled();
        c.motion.covariance += s.self_check.offset_variance_px2() * change * change.transpose();
      }
      s.accept(c, *reference);
    } else {
      s.carry_on();
    }
    s.mover_tracker.update(*reference, *s.current, s.estimator.others(), c.motion.T_prev_cur,
                           c.status == Status::valid);
  }
  e.T_world_camera = s.current->T_world_camera;
  e.calibration = s.self_check.result();
  e.vehicle_part = s.mover_tracker.vehicle_part();
  e.times.total_ns = monotonic_ns() - start_ns;
  return {};
}

const Estimate& VisualOdometry::estimate() const { return impl_->estimate; }
const Movers& VisualOdometry::movers() const { return impl_->mover_tracker.movers(); }

void VisualOdometry::reset() {
  impl_->valid = impl_->key = impl_->failed = nullptr;
  impl_->velocity_ns = 0;
  impl_->wary = {};
  impl_->self_check.reset();
  impl_->mover_tracker.reset();
  impl_->estimate = {};
}

}  // namespace cliquevo::vo
