// SPDX-License-Identifier: BSD-3-Clause
// The daemon's health for Prometheus, in its text format.
#pragma once

#include <string>

#include "tools/view/feed.h"

namespace cliquevo::view {

std::string metrics_text(const FeedState& state, const std::string& version);

}  // namespace cliquevo::view
