// SPDX-License-Identifier: BSD-3-Clause
// Definitions of ROS 2's message types, in the form that MCAP's ros2msg has: the type's own, then of every type in it.
#pragma once

#include <string>
#include <string_view>

namespace cliquevo::drivers {

// "nav_msgs/Odometry"; empty for a type that is not known.
std::string ros2_definition(std::string_view type);

}  // namespace cliquevo::drivers
