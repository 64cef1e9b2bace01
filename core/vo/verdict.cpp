// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/verdict.h"

namespace cliquevo::vo {

Status verdict(const Checks& checks) {
  for (const CheckRow& row : kCheckRows) {
    if (checks[row.check].fails()) return row.status;
  }
  return Status::valid;
}

const char* check_name(Check check) {
  for (const CheckRow& row : kCheckRows) {
    if (row.check == check) return row.name;
  }
  return "unknown";
}

const char* status_name(Status status) {
  switch (status) {
    case Status::no_data:
      return "no data";
    case Status::valid:
      return "valid";
    case Status::too_few_features:
      return "too few features";
    case Status::degenerate:
      return "degenerate";
    case Status::reprojection_error:
      return "reprojection error";
    case Status::ambiguous:
      return "ambiguous";
    case Status::weak:
      return "weakly known";
  }
  return "unknown";
}

}  // namespace cliquevo::vo
