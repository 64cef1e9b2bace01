// SPDX-License-Identifier: BSD-3-Clause
// What is known about the cameras as a message (calibration_t), to the last bit.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "drivers/frame_source.h"

namespace cliquevo::drivers {

std::vector<std::uint8_t> encode_calibration(const SourceInfo& info, TimestampNs now_ns);
// Fills in sizes, rate, calibration and masks; checks them as those from files.
Result<SourceInfo> parse_calibration_message(const std::uint8_t* data, std::size_t size, const std::string& path);

}  // namespace cliquevo::drivers
