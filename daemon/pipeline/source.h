// SPDX-License-Identifier: BSD-3-Clause
// Opens the source that the configuration names.
#pragma once

#include <functional>
#include <memory>
#include <string>

#include "core/base/result.h"
#include "daemon/pipeline/config.h"
#include "drivers/frame_source.h"

namespace cliquevo::daemon {

// One try; an error that waiting may cure sets trouble to another value than lasting.
Result<std::unique_ptr<drivers::FrameSource>> open_source(const SourceConfig& config, drivers::OpenTrouble& trouble);
Result<std::unique_ptr<drivers::FrameSource>> open_source(const SourceConfig& config);
// Tries again for wait_s while waiting may help and until stopped().
Result<std::unique_ptr<drivers::FrameSource>> open_source_within(const SourceConfig& config, double wait_s,
                                                                 const std::function<bool()>& stopped);
// The values of source.type that this build has.
std::string built_in_sources();

// Plays a finite source (a simulated course) forward, then backward, without end: continuous motion with stamps and
// numbers that go on rising. All its frames are read into memory first; fails when that takes more than max_bytes or
// there are fewer than two frames.
Result<std::unique_ptr<drivers::FrameSource>> make_pingpong(std::unique_ptr<drivers::FrameSource> source,
                                                            std::size_t max_bytes = std::size_t{2} << 30);

}  // namespace cliquevo::daemon
