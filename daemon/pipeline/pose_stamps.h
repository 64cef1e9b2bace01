// SPDX-License-Identifier: BSD-3-Clause
// The stamps of a trajectory file's rows, in whatever unit.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "daemon/pipeline/pose_row.h"

namespace cliquevo::daemon {

// The row's stamp in the reader's column (or columns); the error names the word. To be called with a stamp column.
Result<TimestampNs> stamp_of(const PoseRow& row, const RowReader& reader);

struct SpacedStamps {
  std::vector<TimestampNs> stamps_ns;
  std::string note;
};
// Whole numbers in no named unit that are too far apart for seconds (ns since boot, say): by the rule for files of
// times. None: they are read one by one.
std::optional<SpacedStamps> stamps_by_spacing(const std::vector<PoseRow>& rows, const RowReader& reader);

}  // namespace cliquevo::daemon
