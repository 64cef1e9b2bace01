// SPDX-License-Identifier: BSD-3-Clause
// What a pair of images shows about how well its rows are epipolar lines: corners of the left image are looked for in
// the right one, up and down as well as along the row. Plain code for a few pairs at the start; not for every frame.
#pragma once

#include <cstdint>
#include <vector>

#include "core/base/camera_model.h"
#include "core/base/image.h"
#include "core/base/result.h"

namespace cliquevo::stereo {

struct RowEvidence {
  int corners = 0;              // looked for
  std::vector<float> off_px;    // of each one found: its row in the right image - the one in the left
  std::vector<float> shift_px;  // of the same: left column - right column (the disparity)

  void add(const RowEvidence& more);
  int found() const { return static_cast<int>(off_px.size()); }
  // Share of the corners found within so many rows.
  double share_within(double rows) const;
  // Median of |off_px|; 1e9 where nothing was found.
  double median_off_px() const;
  // Disparity that this share of the corners found stays below; 0 where nothing was found.
  double disparity_px(double share) const;
};

// Both images of one size. Rows up to a twentieth of the height off and disparities from -1/16 to 1/4 of the width are
// looked for; a corner counts when its best place is clearly better than any other and leads back to it.
RowEvidence measure_rows(ImageView<const std::uint8_t> left, ImageView<const std::uint8_t> right);

// The same after rectification by this calibration.
Result<RowEvidence> measure_rows(const StereoCalibration& calibration, ImageView<const std::uint8_t> left,
                                 ImageView<const std::uint8_t> right);

}  // namespace cliquevo::stereo
