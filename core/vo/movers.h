// SPDX-License-Identifier: BSD-3-Clause
// What moves otherwise than the world: cliques beyond the first, each a rigid object with a motion of its own, followed
// from frame to frame. One that stands still in the view while the world moves is a part of the vehicle, or its shadow.
#pragma once

#include <array>
#include <string>

#include <Eigen/Core>

#include "core/base/rigid_transform.h"
#include "core/base/time.h"

namespace cliquevo::vo {

inline constexpr int kMostMovers = 4;        // in a frame
inline constexpr int kMostMoverPoints = 32;  // listed of each

// A matched point of a mover.
struct MoverPoint {
  float x_px = 0.0F;                                // in the current left image
  float y_px = 0.0F;                                // likewise
  Eigen::Vector3f point = Eigen::Vector3f::Zero();  // m, current camera's frame
};

// One rigid thing that moves otherwise than the world.
struct Mover {
  int id = 0;               // the same object keeps it for as long as it is found again; rises, never used twice
  int frames = 0;           // in which it was found, this one included
  bool of_vehicle = false;  // see VehiclePart
  // The motion that the camera would have made if this object stood still instead of the world: P_prev = T P_cur for
  // its points, each as seen by the camera of its time.
  RigidTransform T_prev_cur;
  Matrix6d covariance = Matrix6d::Identity();              // left perturbation [translation, rotation vector]
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();        // mean of its points, m, current camera's frame
  Eigen::Vector3d velocity_m_s = Eigen::Vector3d::Zero();  // of its centre against the world, current camera's axes
  double reprojection_error_px = 0.0;                      // RMS
  int inliers = 0;                                         // matches that move so
  int points = 0;                                          // of these, listed below
  std::array<MoverPoint, kMostMoverPoints> point = {};     // the first `points` of them
};

// Of one frame; none where its own motion is not valid.
struct Movers {
  TimestampNs stamp_ns = 0;                   // of the frame
  TimestampNs prev_stamp_ns = 0;              // of the frame that the motions are measured from
  int count = 0;                              // of movers
  std::array<Mover, kMostMovers> mover = {};  // the first `count` of them
};

// Something that stood still in the view for many frames in which the world behind it moved. A mask should cover it.
struct VehiclePart {
  int frames = 0;  // in which it was found so since the start; 0 = nothing found
  // Around its points.
  double left_px = 0.0;    // least column
  double top_px = 0.0;     // least row
  double right_px = 0.0;   // largest column
  double bottom_px = 0.0;  // largest row
};

// One sentence; empty where nothing was found.
std::string describe(const VehiclePart& part);

}  // namespace cliquevo::vo
