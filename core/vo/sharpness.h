// SPDX-License-Identifier: BSD-3-Clause
// How sharp a picture is beside another one, so that a change of blur is not taken for a change of what is seen.
#pragma once

#include <vector>

#include "core/vo/frame.h"

namespace cliquevo::vo {

// 1 - correlation that patches have with themselves in a picture of another blur, as far as it is more than chance:
// blur takes the part H of a patch L + H away, which leaves a correlation of |L| / |L + H|. From the medians over the
// frames' matches, which were chosen in both pictures alike, of how the variance within patches changed, beside that
// between large parts of the picture (which exposure changes, and blur does not), and of how their squared gradients
// changed in four directions: pictures blurred in different directions each lack a part of the other.
double change_by_blur(const Frame& reference, const Frame& current, const std::vector<Match>& matches,
                      std::vector<float>& scratch);

}  // namespace cliquevo::vo
