// SPDX-License-Identifier: BSD-3-Clause
// Images of ROS messages to grey pictures.
#pragma once

#include <string>

#include "drivers/bags/ros_messages.h"
#include "drivers/images/grey_picture.h"

namespace cliquevo::drivers {

// Whether it is the name of an encoding that can be read.
bool is_known_encoding(std::string_view encoding);
// Whether images of this encoding are raw Bayer mosaics: to_grey() leaves them so.
bool is_mosaic_encoding(std::string_view encoding);
// Into `picture`, whose memory is reused. Returns what the user should do where it cannot be taken; empty = done.
std::string to_grey(const RosImage& image, GreyPicture& picture);

}  // namespace cliquevo::drivers
