// SPDX-License-Identifier: BSD-3-Clause
// What a key of a calibration file means, by the words in it: cameraMatrixL, left_K, K1, mtx_l, LEFT.K and
// cam0.camera_matrix are all the left camera's camera matrix. The words for quantities and cameras are known; how they
// are joined, in what order and with what beside them does not matter.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace cliquevo::drivers {

enum class Quantity {
  none,
  camera_matrix,  // 9 numbers, or fx fy cx cy
  distortion,     //
  rotation,       // 9 numbers, a rotation vector or a quaternion
  translation,    // 3
  pose,           // 12 or 16
  rectification,  // 9
  projection,     // 12
  size,           // width, height
  shape,          // height, width
  width,
  height,
  lens,              // a model's name
  focal,             // fx and fy in one
  focals,            // fx, fy
  centre,            // cx, cy
  fx,                //
  fy,                //
  cx,                //
  cy,                //
  k,                 // radial term `index`
  p,                 // tangential term `index`
  s,                 // thin-prism term `index`
  xi,                //
  alpha,             //
  beta,              //
  baseline,          // in the file's unit
  baseline_in_unit,  // in the unit of its name
  bf,                // baseline times fx, px m
  row_offset,        // of the right image, px: index 0 = rows, 1 = disparity
  // Of a camera's pose the other way round ("R_cam_to_world"): from the camera to a common frame.
  rotation_outwards,     // 9 numbers or a rotation vector
  translation_outwards,  // 3
};

enum class KeySide { none, left, right, both };

struct KeyMeaning {
  Quantity quantity = Quantity::none;
  KeySide side = KeySide::none;  // by words
  std::optional<int> number;     // of a camera: left or right depends on the others' numbers
  int index = 0;                 // of a term
  bool body_first = false;       // of a pose: "T_imu_cam", "body_T_cam", "T_BS": takes the camera's points to a body
  bool against_body = false;     // of a pose: against a third frame
  double unit_m = 0.0;           // of a length: metres a unit, by a word such as mm; 0 = none named
};

// Metres a unit of length: "mm", "metres", "inch"; 0 = it is none.
double unit_named(const std::string& word);

// `path`: the keys from the outermost to the value; `count`: how many numbers it has (0: a word).
KeyMeaning meaning_of(const std::vector<std::string>& path, std::size_t count);

}  // namespace cliquevo::drivers
