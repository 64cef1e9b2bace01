// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/threads/pipeline_types.h"

#include <array>
#include <cstddef>

namespace cliquevo::daemon {

const char* stage_name(StageId stage) {
  constexpr std::array<const char*, kStages> kNames{"stereo", "odometry", "output"};
  return kNames[static_cast<std::size_t>(stage)];
}

const char* span_name(Span span) {
  constexpr std::array<const char*, kSpans> kNames{"stereo", "odometry", "output", "wake", "total"};
  return kNames[static_cast<std::size_t>(span)];
}

}  // namespace cliquevo::daemon
