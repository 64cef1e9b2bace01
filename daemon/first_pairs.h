// SPDX-License-Identifier: BSD-3-Clause
// A live source's first pairs are looked at once, beside everything else, for what they contradict in the calibration.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "drivers/frame_source.h"

namespace cliquevo::daemon {

// The source itself where it is none of live cameras: recordings were looked at when they were opened. `report` gets
// one line, from a thread of its own.
std::unique_ptr<drivers::FrameSource> examine_first_pairs(std::unique_ptr<drivers::FrameSource> source,
                                                          std::function<void(const std::string&)> report);

}  // namespace cliquevo::daemon
