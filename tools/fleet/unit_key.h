// SPDX-License-Identifier: BSD-3-Clause
// The key of a unit: a hash of all that decides its result, and of nothing else.
#pragma once

#include <memory>
#include <string>

#include "core/base/result.h"
#include "daemon/pipeline/config.h"
#include "drivers/frame_source.h"

namespace cliquevo::tools::fleet {

// Opens it as a unit plays it: on one thread, without what a vehicle's configuration says of cameras. The notes on
// calibrations are not printed.
Result<std::unique_ptr<drivers::FrameSource>> open_unit_source(const std::string& source, const daemon::Config& config);

// What is played, whatever its path: a recording's fingerprint, its calibration and masks as they were read, and the
// reference beside it; of the simulator its options.
struct SourceIdentity {
  std::string digest;
  std::int64_t frames = -1;  // as SourceInfo
  std::int64_t bytes = 0;
};
// opened: of open_unit_source. Error: it is not there (any more).
Result<SourceIdentity> identify(const std::string& source, const daemon::Config& config,
                                const drivers::SourceInfo& opened);
// The same of the simulator, of which nothing need be opened.
Result<SourceIdentity> identify_simulated(const std::string& source, const daemon::Config& config);

// The part of the configuration that decides how a source is read: equal texts, equal identities.
std::string reading_text(const daemon::Config& config);

// 64 hexadecimal digits.
std::string unit_key(const std::string& build, const daemon::Config& config, const SourceIdentity& source,
                     bool trajectory);

}  // namespace cliquevo::tools::fleet
