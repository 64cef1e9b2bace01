// SPDX-License-Identifier: BSD-3-Clause
// Finds what a replayed trajectory can be held against.
#pragma once

#include <optional>
#include <string>

#include "core/base/result.h"
#include "tools/run_log.h"

namespace cliquevo::tools {

// A file that recordings bring along as their reference (poses.txt, groundtruth.tum); empty when there is none.
std::string reference_beside(const std::string& recording);

// The poses of a file that belong to the frames of the run: by the pairs' positions in the recording (KITTI), by stamp
// (TUM). Fails when the file cannot be read or does not reach as far as the run.
Result<RunReference> reference_from_file(const std::string& path, const std::vector<FrameRecord>& frames);
// What the source itself knew to be true.
std::optional<RunReference> reference_from_truth(const std::vector<FrameRecord>& frames);

}  // namespace cliquevo::tools
