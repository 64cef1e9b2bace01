// SPDX-License-Identifier: BSD-3-Clause
// Pairs of a source that could not be played: a torn image, a stamp that steps back. They are reported and counted.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace cliquevo::tools {

class SkippedPairs {
 public:
  struct Entry {
    std::int64_t index = 0;  // in the source
    Error error;
  };

  // Reports the first few on stderr, and that more follow.
  void add(std::int64_t index, const Error& error);
  const std::vector<Entry>& entries() const { return entries_; }
  bool empty() const { return entries_.empty(); }
  std::int64_t count() const { return static_cast<std::int64_t>(entries_.size()); }

 private:
  std::vector<Entry> entries_;
};

}  // namespace cliquevo::tools
