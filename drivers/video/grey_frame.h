// SPDX-License-Identifier: BSD-3-Clause
// Decoded frames of libav to grey.
#pragma once

#include <cstdint>

#include "core/base/image.h"

struct AVFrame;

namespace cliquevo::drivers {

// false: the pixel format has no brightness that can be read.
bool grey_of_frame(const AVFrame& frame, Image<std::uint8_t>& out);

}  // namespace cliquevo::drivers
