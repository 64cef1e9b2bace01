// SPDX-License-Identifier: BSD-3-Clause
// Which topics of a bag are the two cameras, and which have their calibration.
#pragma once

#include <string>
#include <vector>

#include "core/base/result.h"
#include "drivers/recording/bag_set.h"

namespace cliquevo::drivers {

struct StereoTopics {
  std::string left;
  std::string right;
  std::string left_info;  // camera_info; empty = none found
  std::string right_info;
  bool rectified = false;  // by their names: image_rect, image_rect_raw, ...
};

// wanted: "LEFT,RIGHT" or "LEFT,RIGHT,LEFT_INFO,RIGHT_INFO"; empty = by types and names. Of a camera's images the
// rectified ones are preferred, then those that are not compressed. An error names what there is.
Result<StereoTopics> choose_topics(const BagSet& bags, const std::string& wanted, const std::string& path);

}  // namespace cliquevo::drivers
