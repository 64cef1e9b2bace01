// SPDX-License-Identifier: BSD-3-Clause
// Formats of trajectory files that need no heading: recognised by the count of words, the commas and the stamp.
#pragma once

#include "daemon/pipeline/pose_row.h"

namespace cliquevo::daemon {

struct PoseKind {
  const char* name;
  const char* words;  // how many a row has, for the list of what is known
  bool (*fits)(const PoseRow&);
  RowReader reader;
};

// The first that fits; nullptr = none.
const PoseKind* pose_kind_of(const PoseRow& row);

// "12 (KITTI), 8 (TUM), ..." for the message where none fits.
std::string known_pose_kinds();

}  // namespace cliquevo::daemon
