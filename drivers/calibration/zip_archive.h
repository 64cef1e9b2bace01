// SPDX-License-Identifier: BSD-3-Clause
// The small members of a zip file that is in memory whole: what NumPy's .npz is.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace cliquevo::drivers {

struct ZipMember {
  std::string name;
  std::string data;
};

bool is_zip(std::string_view bytes);

// Stored and deflated members of at most `most_bytes`; larger ones are passed over, and so are all behind the first
// `most_members`. Errors: torn, encrypted, packed otherwise, a checksum that does not fit.
Result<std::vector<ZipMember>> read_zip(std::string_view bytes, const std::string& path, std::size_t most_bytes,
                                        std::size_t most_members);

}  // namespace cliquevo::drivers
