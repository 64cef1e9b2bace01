// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/mover_tracker.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace cliquevo::vo {

namespace {

constexpr std::size_t kTracks = 16;
constexpr int kPublishedFrom = 3;                // frames; chance cliques are not found that often
constexpr std::int64_t kForgetNs = 500'000'000;  // an object not found for longer gets a new number
constexpr double kSharedFeatures = 0.25;         // of the smaller set: the same object
constexpr double kStill_px = 1.0;                // change of u, v and disparity: stands still in the view ...
constexpr double kWorldMoved_px = 3.0;           // ... while the world would have moved by so much there (RMS)
constexpr double kSamePlace_px = 1.5;            // from one of the first places, in u, v and disparity
constexpr double kMostPoints = 0.6;              // of which these hold
constexpr int kErrCosts = 5;                     // frames, for one that contradicts
constexpr int kVehicleFrom = 30;                 // frames: no other vehicle keeps its place to a pixel for so long

int common(const std::vector<int>& a, const std::vector<int>& b) {
  int count = 0;
  for (auto i = a.begin(), j = b.begin(); i != a.end() && j != b.end();) {
    if (*i < *j) {
      ++i;
    } else if (*j < *i) {
      ++j;
    } else {
      ++count, ++i, ++j;
    }
  }
  return count;
}

bool near(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double most) {
  return (a - b).cwiseAbs().maxCoeff() <= most;
}

bool near_any(const std::vector<Eigen::Vector3d>& places, const Eigen::Vector3d& p) {
  return std::any_of(places.begin(), places.end(),
                     [&p](const Eigen::Vector3d& place) { return near(place, p, kSamePlace_px); });
}

double shared(const std::vector<int>& a, const std::vector<int>& b) {
  const std::size_t smaller = std::min(a.size(), b.size());
  return smaller > 0 ? static_cast<double>(common(a, b)) / static_cast<double>(smaller) : 0.0;
}

}  // namespace

std::string describe(const VehiclePart& v) {
  if (v.frames == 0) return "";
  char text[256];
  std::snprintf(
      text, sizeof text,
      "a part of the vehicle, or its shadow, stands in the view (%.0f to %.0f px across, %.0f to %.0f px down, "
      "%d frames): give it to a mask",
      v.left_px, v.right_px, v.top_px, v.bottom_px, v.frames);
  return text;
}

MoverTracker::MoverTracker(const StereoModel& model, const VoParams& params) : model_(model), tracks_(kTracks) {
  const std::size_t n = static_cast<std::size_t>(params.max_features);
  const auto reserve = [n](Track& t) {
    t.reference_features.reserve(n);
    t.current_features.reserve(n);
    t.anchor.reserve(n);
  };
  reserve(seen_);
  for (Track& t : tracks_) reserve(t);
  published_.reserve(kTracks);
}

void MoverTracker::measure(const OtherMotion& other, const Frame& reference, const Frame& current,
                           const RigidTransform& T_ref_cur) {
  Track& s = seen_;
  Mover& m = s.mover;
  s.reference_ns = reference.stamp_ns;
  s.current_ns = current.stamp_ns;
  s.reference_features.clear();
  s.current_features.clear();
  m.T_prev_cur = other.motion.T_prev_cur;
  m.covariance = other.motion.covariance;
  m.reprojection_error_px = other.motion.error_px;
  m.inliers = static_cast<int>(other.matches.size());
  m.points = 0;
  m.centre.setZero();
  for (const Match& match : other.matches) {
    const Feature& f = current.features[static_cast<std::size_t>(match.b)];
    s.reference_features.push_back(match.a);
    s.current_features.push_back(match.b);
    m.centre += f.point / m.inliers;
    if (m.points == kMostMoverPoints) continue;
    m.point[static_cast<std::size_t>(m.points++)] = {static_cast<float>(f.x), static_cast<float>(f.y),
                                                     f.point.cast<float>()};
  }
  std::sort(s.reference_features.begin(), s.reference_features.end());
  std::sort(s.current_features.begin(), s.current_features.end());
  double squares = 0.0;
  for (const int i : s.current_features) {
    squares += (current.features[static_cast<std::size_t>(i)].point - m.centre).squaredNorm();
  }
  s.radius_m = std::sqrt(squares / m.inliers);
  // Where its centre was, as the current camera would see that place, had the world moved with it.
  const Eigen::Vector3d before = T_ref_cur.inverse() * (other.motion.T_prev_cur * m.centre);
  m.velocity_m_s = (m.centre - before) / (1e-9 * static_cast<double>(current.stamp_ns - reference.stamp_ns));
  s.centre_world = current.T_world_camera * m.centre;
  s.velocity_world = current.T_world_camera.R * m.velocity_m_s;
}

// By the features that it shares with what was found before, else by its place.
MoverTracker::Track& MoverTracker::known_or_new() {
  Track* best = nullptr;
  double most = kSharedFeatures;
  for (Track& t : tracks_) {
    if (!t.alive || t.found) continue;
    double share = 0.0;
    if (t.current_ns == seen_.reference_ns) share = shared(t.current_features, seen_.reference_features);
    if (t.reference_ns == seen_.reference_ns) share = shared(t.reference_features, seen_.reference_features);
    if (share < most) continue;
    most = share;
    best = &t;
  }
  if (best != nullptr) return *best;
  double nearest = 1.0;
  for (Track& t : tracks_) {
    if (!t.alive || t.found) continue;
    const double gone_s = 1e-9 * static_cast<double>(seen_.current_ns - t.current_ns);
    const Eigen::Vector3d expected = t.centre_world + gone_s * t.velocity_world;
    const double distance = (seen_.centre_world - expected).norm() / std::max(t.radius_m, seen_.radius_m);
    if (!(distance < nearest)) continue;
    nearest = distance;
    best = &t;
  }
  if (best != nullptr) return *best;
  best = &tracks_.front();
  for (Track& t : tracks_) {
    if (!t.alive || (best->alive && t.current_ns < best->current_ns)) best = &t;
  }
  best->alive = true;
  best->mover.id = ++last_id_;
  best->mover.frames = 0;
  best->mover.of_vehicle = false;
  best->still = 0;
  return *best;
}

void MoverTracker::detect_vehicle_part(const OtherMotion& other, const RigidTransform& T_ref_cur, Track& track) {
  double world = 0.0;
  int unmoved = 0, kept = 0;
  for (const Observation& o : other.observations) {
    const Eigen::Vector3d p = T_ref_cur * model_.triangulate(o.uvd_cur.x(), o.uvd_cur.y(), o.uvd_cur.z());
    const Eigen::Vector2d from(model_.fx_px * p.x() / p.z() + model_.cx_px,
                               model_.fy_px * p.y() / p.z() + model_.cy_px);
    world += (o.uvd_cur.head<2>() - from).squaredNorm();
    unmoved += near(o.uvd_ref, o.uvd_cur, kStill_px) ? 1 : 0;
    kept += near_any(track.anchor, o.uvd_cur) ? 1 : 0;
  }
  const double n = static_cast<double>(other.observations.size());
  if (!(world > n * kWorldMoved_px * kWorldMoved_px)) return;  // the world did not move enough to tell them apart
  const bool still = unmoved >= kMostPoints * n;
  if (track.still > 0 && (!still || kept < kMostPoints * n)) {  // one frame may be wrong
    track.still = std::max(0, track.still - kErrCosts);
    track.mover.of_vehicle = track.still >= kVehicleFrom;
    return;
  }
  if (track.still == 0) {
    if (!still) return;
    track.anchor.clear();
    for (const Observation& o : other.observations) track.anchor.push_back(o.uvd_cur);
  }
  track.mover.of_vehicle = ++track.still >= kVehicleFrom;
  if (!track.mover.of_vehicle) return;
  VehiclePart& v = vehicle_part_;
  bool first = v.frames == 0;
  for (const Observation& o : other.observations) {
    if (!near(o.uvd_ref, o.uvd_cur, kStill_px) || !near_any(track.anchor, o.uvd_cur)) continue;
    const double x = o.uvd_cur.x(), y = o.uvd_cur.y();
    v.left_px = first ? x : std::min(v.left_px, x);
    v.right_px = first ? x : std::max(v.right_px, x);
    v.top_px = first ? y : std::min(v.top_px, y);
    v.bottom_px = first ? y : std::max(v.bottom_px, y);
    first = false;
  }
  ++v.frames;
}

void MoverTracker::publish(const Frame& reference) {
  published_.clear();
  for (const Track& t : tracks_) {
    if (t.alive && t.found && t.mover.frames >= kPublishedFrom) published_.push_back(&t);
  }
  std::sort(published_.begin(), published_.end(), [](const Track* a, const Track* b) {
    return a->mover.frames != b->mover.frames ? a->mover.frames > b->mover.frames : a->mover.id < b->mover.id;
  });
  movers_.prev_stamp_ns = reference.stamp_ns;
  movers_.count = std::min(static_cast<int>(published_.size()), kMostMovers);
  for (int i = 0; i < movers_.count; ++i) {
    movers_.mover[static_cast<std::size_t>(i)] = published_[static_cast<std::size_t>(i)]->mover;
  }
}

void MoverTracker::update(const Frame& reference, const Frame& current, const OtherMotions& others,
                          const RigidTransform& T_ref_cur, bool valid) {
  skip(current);
  for (std::size_t i = 0; i < others.size(); ++i) {
    measure(others[i], reference, current, T_ref_cur);
    Track& track = known_or_new();
    track.found = true;
    const int id = track.mover.id, frames = track.mover.frames;
    const bool of_vehicle = track.mover.of_vehicle;
    track.mover = seen_.mover;
    track.mover.id = id;
    track.mover.frames = frames + 1;
    track.mover.of_vehicle = of_vehicle;
    track.reference_ns = seen_.reference_ns;
    track.current_ns = seen_.current_ns;
    track.reference_features.swap(seen_.reference_features);
    track.current_features.swap(seen_.current_features);
    track.centre_world = seen_.centre_world;
    track.velocity_world = seen_.velocity_world;
    track.radius_m = seen_.radius_m;
    detect_vehicle_part(others[i], T_ref_cur, track);
  }
  if (valid) publish(reference);
}

void MoverTracker::skip(const Frame& current) {
  movers_.stamp_ns = current.stamp_ns;
  movers_.prev_stamp_ns = current.stamp_ns;
  movers_.count = 0;
  for (Track& t : tracks_) {
    t.found = false;
    if (current.stamp_ns - t.current_ns > kForgetNs) t.alive = false;
  }
}

void MoverTracker::reset() {
  for (Track& t : tracks_) t.alive = false;
  movers_ = {};
  vehicle_part_ = {};
}

}  // namespace cliquevo::vo
