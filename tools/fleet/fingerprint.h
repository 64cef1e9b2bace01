// SPDX-License-Identifier: BSD-3-Clause
// Whether a recording is still the one that it was, without reading all of it.
#pragma once

#include <cstdint>
#include <string>

#include "core/base/result.h"

namespace cliquevo::tools::fleet {

struct Fingerprint {
  std::string digest;      // of names, sizes, times of all files, and of some of their bytes
  std::int64_t bytes = 0;  // all files together
  std::int64_t files = 0;
};

// Of a folder with all that is below it, a file, or LEFT,RIGHT. A few hundred kB are read, and the size and time of
// every file. The recording may lie elsewhere: names count from its own folder. Error: it is not there, or cannot be
// read.
Result<Fingerprint> fingerprint_of(const std::string& recording);

}  // namespace cliquevo::tools::fleet
