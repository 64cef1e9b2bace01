// SPDX-License-Identifier: BSD-3-Clause
// From the corners of a board in pairs of images to a stereo calibration with its uncertainty.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "drivers/board_calibration/adjustment.h"

namespace cliquevo::calibration {

struct SolveOptions {
  std::string model = "auto";  // a lens model's name, or by the error on views held out
  bool square_pixels = false;
  bool held_out = true;  // whether errors on views held out are measured; `auto` needs them
  std::function<void(const std::string& step)> progress;  // may be empty
};

struct DroppedCorner {
  std::string view;
  Side side = Side::left;
  int id = 0;
  double error_px = 0.0;
};

// Errors on views that the calibration did not see: five times, each with a fifth of the views.
struct HeldOut {
  double row_rms_px = 0.0;           // difference of rows after rectification, left to right
  double reprojection_rms_px = 0.0;  // a coordinate, after the board's pose was fitted
  int corners = 0;                   // seen by both cameras
};

struct Solution {
  Adjusted adjusted;
  std::vector<View> views;  // that were used, with the corners that were used
  std::vector<std::string> dropped_views;
  std::vector<DroppedCorner> dropped_corners;
  HeldOut held_out;
  struct Tried {
    std::string model;
    HeldOut held_out;
  };
  std::vector<Tried> tried;  // models, with `auto`

  const Rig& rig() const { return adjusted.rig; }
};

// Fails, saying why, with too few views, views that are all parallel, cameras that are exchanged, no view with both.
Result<Solution> solve(const Board& board, std::vector<View> views, int width, int height, const SolveOptions& options);

// RMS of the length of the reprojection error of one side of one view, px.
double rms_px(const Board& board, const Rig& rig, const RigidTransform& T_left_board, const View& view, Side side);
// The same over all.
double rms_px(const Board& board, const Solution& solution);

}  // namespace cliquevo::calibration
