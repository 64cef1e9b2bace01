// SPDX-License-Identifier: BSD-3-Clause
#include "tools/skipped_pairs.h"

#include "tools/exit_code.h"

namespace cliquevo::tools {

void SkippedPairs::add(std::int64_t index, const Error& error) {
  constexpr std::size_t kTold = 5;
  entries_.push_back({index, error});
  if (entries_.size() <= kTold)
    warn({"skipped pair " + std::to_string(index) + ", " + error.what, error.where, error.remedy});
  if (entries_.size() == kTold) warn({"skipped pairs", "from here on", "they are counted only"});
}

}  // namespace cliquevo::tools
