// SPDX-License-Identifier: BSD-3-Clause
// From VO_ODOMETRY to MAVLink: forward-left-up becomes forward-right-down.
#pragma once

#include <cliquevo/odometry_t.hpp>

#include "tools/mavlink_wire.h"

namespace cliquevo::tools {

mavlink::Odometry mavlink_odometry(const odometry_t& m);
mavlink::VisionPosition mavlink_vision_position(const odometry_t& m);

}  // namespace cliquevo::tools
