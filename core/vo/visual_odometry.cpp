// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/visual_odometry.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <span>
#include <utility>
#include <vector>

#include "core/vo/caution.h"
#include "core/vo/dead_reckoning.h"
#include "core/vo/estimator.h"
#include "core/vo/mover_tracker.h"
#include "core/vo/noise.h"
#include "core/vo/reference_frames.h"
#include "core/vo/seen_features.h"
#include "core/vo/uncertainty.h"

namespace cliquevo::vo {

namespace {
// Where nothing is known of the speed: straight ahead at these.
constexpr double kSpeeds_m_s[] = {0.0, 8.0, 14.0, 20.0, 26.0, 32.0, 38.0};
}  // namespace

struct VisualOdometry::Impl {
  Impl(const StereoModel& model_, const VoParams& params_)
      : model(model_),
        params(params_),
        detector(model_, params_),
        tracker(model_, params_),
        estimator(model_, params_),
        self_check(model_, params_),
        mover_tracker(model_, params_),
        frames(model_, params_),
        dead_reckoning(params_) {}

  Result<void> check(const FrameInput& input) const;
  void load(const FrameInput& input);
  void begin();
  void follow(const FrameInput& input);
  Comparison compare_with(const Frame& reference, const Frame* key, const FrameInput& input);
  std::pair<Comparison, const Frame*> compare(const FrameInput& input);
  void report(const Comparison& comparison);
  void accept(const Comparison& comparison, const Frame& reference);
  void place_failed_frame(const RigidTransform& motion_after);
  void carry_on();
  std::span<const RigidTransform> predictions(const Frame& since);

  StereoModel model;
  VoParams params;
  FeatureDetector detector;
  Tracker tracker;
  Estimator estimator;
  SelfCheck self_check;
  CameraNoise noise;
  Caution caution;
  MoverTracker mover_tracker;
  Image<std::uint8_t> mask;
  ReferenceFrames frames;
  Frame* current = nullptr;
  const Frame* compared = nullptr;  // what the current frame was last compared with
  RigidTransform T_compared_current;
  std::size_t older_turn = 0;  // whose turn it is among the older frames, in a gap
  std::array<RigidTransform, std::size(kSpeeds_m_s)> predicted;
  DeadReckoning dead_reckoning;
  Matrix6d guess_covariance = Matrix6d::Zero();
  Estimate estimate;
};

Result<void> VisualOdometry::Impl::check(const FrameInput& input) const {
  const auto fits = [&](const auto& view) { return !view.empty() && view.same_size(model.width, model.height); };
  if (!fits(input.left) || !fits(input.right) || !fits(input.filtered_left) || !fits(input.disparity)) {
    return Error{"unusable frame", "an image is empty or not of the calibration's size",
                 "hand over left, right, filtered and disparity images of the stereo model's size"};
  }
  if (frames.valid() != nullptr && input.stamp_ns <= frames.last().stamp_ns) {
    return Error{"unusable frame", "its time stamp does not advance",
                 "hand over frames in the order of their exposure"};
  }
  return {};
}

// Bit for bit. Images that differ mostly do so in their first row.
bool same_image(const Image<std::uint8_t>& a, const Image<std::uint8_t>& b) {
  if (a.width() != b.width() || a.height() != b.height()) return false;
  const auto va = a.cview();
  const auto vb = b.cview();
  for (int y = 0; y < a.height(); ++y) {
    if (std::memcmp(va.row(y), vb.row(y), static_cast<std::size_t>(a.width())) != 0) return false;
  }
  return true;
}

// Step A2: features of the new frame, their depth and descriptors.
void VisualOdometry::Impl::load(const FrameInput& input) {
  current = frames.spare();
  compared = nullptr;
  current->stamp_ns = input.stamp_ns;
  current->shift_px = 0.0;
  current->velocity.setZero();
  current->velocity_before.setZero();
  current->turn_rate.setZero();
  current->left.copy_from(input.left);
  current->right.copy_from(input.right);
  current->one_camera_repeats = frames.valid() != nullptr && same_image(current->left, frames.last().left) !=
                                                                 same_image(current->right, frames.last().right);
  detector.detect(params.corner_image == CornerImage::filtered ? input.filtered_left : input.left, input.disparity,
                  mask.cview(), self_check.disparity_error_px(model.cx_px, model.cy_px), current->features);
  current->descriptors.extract(input.filtered_left, current->features, params.descriptor_window);
  current->coarse_descriptors.extract_coarse(input.filtered_left, current->features);
  if (!params.refine) return;
  tracker.measure_views(input.disparity, self_check, *current);
  if (frames.valid() == nullptr) noise.add_views(*current);
  tracker.refine_disparities({self_check, 0.0, noise.row_shift_px(*current)}, *current);
  estimator.prepare(input.disparity, *current);
}

// The first frame: nothing to compare with.
void VisualOdometry::Impl::begin() {
  estimate.prev_stamp_ns = current->stamp_ns;
  current->T_world_camera = {};
  frames.accept(current, Matrix6d::Zero(), true);
  mover_tracker.skip(*current);
}

// Every further frame.
void VisualOdometry::Impl::follow(const FrameInput& input) {
  estimate.prev_stamp_ns = frames.valid()->stamp_ns;
  const auto [comparison, reference] = compare(input);
  const bool valid = comparison.status == Status::valid;
  caution.next(valid);
  report(comparison);
  if (valid) {
    if (params.refine) {
      noise.add_views(*current);
      noise.add_motion(comparison.motion);
      self_check.add_offset(comparison.motion.offset_px, comparison.motion.offset_information);
    }
    accept(comparison, *reference);
  } else {
    carry_on();
  }
  mover_tracker.update(*reference, *current, estimator.others(), comparison.motion.T_prev_cur, valid);
}

// With the last valid frame and the key frame; where that fails, with the failed frame before (whose place is a guess);
// in a gap also with frames of the way, one of the older ones at a time: where views overlap, a gap ends with the true
// motion across it.
std::pair<Comparison, const Frame*> VisualOdometry::Impl::compare(const FrameInput& input) {
  // What has been learned of the calibration since a frame was taken goes into its points.
  const auto up_to_date = [this](Frame* frame) {
    if (params.refine) tracker.compensate(self_check, *frame);
  };
  const Frame* reference = frames.valid();
  up_to_date(frames.valid());
  if (frames.key() != frames.valid()) up_to_date(frames.key());
  Comparison found = compare_with(*reference, frames.key(), input);
  if (found.status == Status::valid || frames.failed() == nullptr) return {found, reference};
  const auto attempt = [&](Frame* frame) {
    if (frame == nullptr || frame == frames.valid() || found.status == Status::valid) return;
    if (frame != frames.key()) up_to_date(frame);
    reference = frame;
    found = compare_with(*frame, nullptr, input);
  };
  attempt(frames.key());
  attempt(frames.older()[older_turn++ % ReferenceFrames::kOlder]);
  attempt(frames.failed());
  return {found, reference};
}

Comparison VisualOdometry::Impl::compare_with(const Frame& reference, const Frame* key, const FrameInput& input) {
  Comparison c = estimator.compare(
      {reference, key, *current, input.disparity, predictions(reference), self_check, noise, caution}, estimate.times);
  compared = c.started || c.motion.inliers > 0 ? &reference : nullptr;
  T_compared_current = c.motion.T_prev_cur;
  caution.learn(c.checks);
  return c;
}

void VisualOdometry::Impl::report(const Comparison& c) {
  estimate.status = c.status;
  estimate.checks = c.checks;
  if (c.status != Status::valid && c.checks.failed() == 0) {  // not even a match: nothing was there to be checked
    const double least = params.min_inliers;
    estimate.checks[Check::inliers] = {least / std::max(1, c.motion.inliers), 1.0, true};
  }
  estimate.matches = c.matches;
  estimate.clique = c.clique;
  estimate.inliers = c.motion.inliers;
  estimate.reprojection_error_px = c.motion.error_px;
  estimate.eigenvalue_ratio = c.eigenvalue_ratio;
  estimate.disparity_offset_px = c.motion.offset_px;
  estimate.disparity_offset_information = c.motion.offset_information;
  estimate.disparity_shift_px = c.motion.shift_px;
  estimate.quality = c.status == Status::valid ? quality(c.checks) : 0;
}

// A gap that ends without a view of what was seen before it: what moves on from it shows how it may have been crossed.
void VisualOdometry::Impl::place_failed_frame(const RigidTransform& motion_after) {
  const Frame& valid = *frames.valid();
  Frame& failed = *frames.failed();
  const RigidTransform T_valid_failed = valid.T_world_camera.inverse() * failed.T_world_camera;
  failed.T_world_camera =
      (valid.T_world_camera * dead_reckoning.across(T_valid_failed, failed.stamp_ns - valid.stamp_ns, motion_after,
                                                    current->stamp_ns - failed.stamp_ns))
          .normalized();
}

void VisualOdometry::Impl::accept(const Comparison& c, const Frame& reference) {
  if (&reference == frames.failed()) place_failed_frame(c.motion.T_prev_cur);
  const RigidTransform T_valid_ref = frames.valid()->T_world_camera.inverse() * reference.T_world_camera;
  current->T_world_camera = (reference.T_world_camera * c.motion.T_prev_cur).normalized();
  current->shift_px = c.motion.shift_px;
  if (model.readout_s > 0.0 && &reference == frames.valid()) {
    const Velocities v = velocities(reference, *current, c.motion.T_prev_cur);
    frames.valid()->velocity = v.reference;
    current->velocity = v.current;
    current->velocity.tail<3>() += c.turn_rate;
    current->turn_rate = c.turn_rate;
    // Over a gap a mean says little of how fast the camera turned at its end.
    if (frames.failed() == nullptr) current->velocity_before = v.before;
  }
  estimate.T_prev_cur = T_valid_ref * c.motion.T_prev_cur;
  const bool of_valid = &reference == frames.valid();
  if (of_valid && frames.key() != frames.valid()) {
    const Matrix6d A = adjoint(dead_reckoning.last_motion().inverse());
    const Matrix6d before = A * frames.covariance_to_valid(*frames.key()) * A.transpose();
    estimate.covariance = with_error_taken_back(c.motion.covariance, before);
  } else if (of_valid) {
    estimate.covariance = c.motion.covariance;
  } else {
    const Matrix6d A = adjoint(T_valid_ref);
    const Matrix6d& between = &reference == frames.failed() ? guess_covariance : frames.covariance_to_valid(reference);
    estimate.covariance = between + A * c.motion.covariance * A.transpose();
  }
  dead_reckoning.learn(estimate.T_prev_cur, current->stamp_ns - frames.valid()->stamp_ns);
  const bool lost_overlap = !params.use_key_frame || c.key_overlap < params.key_frame_overlap;
  frames.accept(current, c.motion.covariance, lost_overlap || !of_valid);
}

// Where to look: on the way that the last motion began, or wherever it may be as long as no speed is known.
std::span<const RigidTransform> VisualOdometry::Impl::predictions(const Frame& since) {
  const Frame& known = frames.failed() == &since ? since : *frames.valid();
  const RigidTransform T_since_known = since.T_world_camera.inverse() * known.T_world_camera;
  const TimestampNs elapsed_ns = current->stamp_ns - known.stamp_ns;
  predicted.fill(T_since_known * dead_reckoning.prediction(elapsed_ns));
  if (dead_reckoning.knows_speed()) return {predicted.data(), 1};
  for (std::size_t k = 0; k < predicted.size(); ++k) {
    predicted[k].t.z() = kSpeeds_m_s[k] * static_cast<double>(elapsed_ns) * 1e-9;
  }
  return predicted;
}

// A failed frame: the pose moves on by the stated guess, and the next attempt may start from here.
void VisualOdometry::Impl::carry_on() {
  const Frame& last = frames.last();
  if (frames.failed() == nullptr) guess_covariance.setZero();
  Vector6d variance;
  const RigidTransform step =
      dead_reckoning.guess(current->stamp_ns - last.stamp_ns, current->stamp_ns - frames.valid()->stamp_ns, variance);
  current->T_world_camera = (last.T_world_camera * step).normalized();
  guess_covariance.diagonal() += variance;
  estimate.T_prev_cur = {};
  estimate.covariance = guess_covariance;
  frames.refuse(current);
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
  e.stamp_ns = input.stamp_ns;
  s.load(input);
  e.features = static_cast<int>(s.current->features.size());
  e.times.features_ns = monotonic_ns() - start_ns;
  if (s.frames.valid() == nullptr) {
    s.begin();
  } else {
    s.follow(input);
  }
  e.T_world_camera = s.current->T_world_camera;
  e.disparity_shift_sigma_px = s.noise.shift_sigma_px();
  e.expected_error_px = s.noise.expected_error_px();
  e.calibration = s.self_check.result();
  e.vehicle_part = s.mover_tracker.vehicle_part();
  e.times.total_ns = monotonic_ns() - start_ns;
  return {};
}

const Estimate& VisualOdometry::estimate() const { return impl_->estimate; }
const Movers& VisualOdometry::movers() const { return impl_->mover_tracker.movers(); }

void VisualOdometry::list_features(std::vector<SeenFeature>& out) const {
  const Impl& s = *impl_;
  list_seen({s.model, s.current, s.compared, s.compared != nullptr ? &s.estimator.observations() : nullptr,
             s.T_compared_current, movers()},
            out);
}

void VisualOdometry::reset() {
  impl_->frames.clear();
  impl_->current = nullptr;
  impl_->compared = nullptr;
  impl_->dead_reckoning.reset();
  impl_->caution = {};
  impl_->noise.reset();
  impl_->self_check.reset();
  impl_->mover_tracker.reset();
  impl_->estimate = {};
}

}  // namespace cliquevo::vo
