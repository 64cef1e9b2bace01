// SPDX-License-Identifier: BSD-3-Clause
// Masks of the vehicle's own parts: image files of the raw images' size, 0 = not to be used.
#pragma once

#include <string>

#include "core/base/result.h"
#include "drivers/frame_source.h"

namespace cliquevo::drivers {

// Into `info`, whose size they must have. Where no file is given, mask_left.png and mask_right.png of the folder `root`
// where they are; without a folder none.
Result<void> read_masks(const std::string& left, const std::string& right, const std::string& root, SourceInfo& info);

}  // namespace cliquevo::drivers
