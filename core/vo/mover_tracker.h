// SPDX-License-Identifier: BSD-3-Clause
// Recognises the moving rigid objects of one frame as those of the frames before.
#pragma once

#include <vector>

#include <Eigen/Core>

#include "core/base/camera_model.h"
#include "core/vo/frame.h"
#include "core/vo/movers.h"
#include "core/vo/other_motions.h"
#include "core/vo/vo_params.h"

namespace cliquevo::vo {

class MoverTracker {
 public:
  MoverTracker(const StereoModel& model, const VoParams& params);

  // `others`: found between the two frames beside the camera's own motion T_ref_cur. Objects are published where that
  // is `valid`, from the third frame on in which they are found; parts of the vehicle are detected in any case.
  void update(const Frame& reference, const Frame& current, const OtherMotions& others, const RigidTransform& T_ref_cur,
              bool valid);
  // A frame without any motion.
  void skip(const Frame& current);
  void reset();
  const Movers& movers() const { return movers_; }
  const VehiclePart& vehicle_part() const { return vehicle_part_; }

 private:
  // An object, when it was last found.
  struct Track {
    bool alive = false;
    bool found = false;  // in this frame
    Mover mover;
    TimestampNs reference_ns = 0;  // the two frames, and its features there, in rising order
    TimestampNs current_ns = 0;
    std::vector<int> reference_features;
    std::vector<int> current_features;
    Eigen::Vector3d centre_world = Eigen::Vector3d::Zero();
    Eigen::Vector3d velocity_world = Eigen::Vector3d::Zero();
    double radius_m = 0.0;                // RMS distance of its points from their centre
    int still = 0;                        // frames in which it stood still in the view though the world moved ...
    std::vector<Eigen::Vector3d> anchor;  // ... since its points were at these (u, v, disparity)
  };
  void measure(const OtherMotion& other, const Frame& reference, const Frame& current, const RigidTransform& T_ref_cur);
  Track& known_or_new();
  void detect_vehicle_part(const OtherMotion& other, const RigidTransform& T_ref_cur, Track& track);
  void publish(const Frame& reference);

  StereoModel model_;
  Track seen_;  // the object being measured, before it is known which one it is
  std::vector<Track> tracks_;
  std::vector<const Track*> published_;
  int last_id_ = 0;
  Movers movers_;
  VehiclePart vehicle_part_;
};

}  // namespace cliquevo::vo
