// SPDX-License-Identifier: BSD-3-Clause
#include "core/vo/verdict.h"

namespace cliquevo::vo {

namespace {

struct Rule {
  Check check;
  const char* name;
  Status status;  // where it fails
};

constexpr Rule kRules[kChecks] = {
    {Check::inliers, "inliers", Status::too_few_features},
    {Check::spread, "spread", Status::degenerate},
    {Check::positions, "positions", Status::reprojection_error},
    {Check::disparities, "disparities", Status::reprojection_error},
    {Check::hanging_camera, "hanging camera", Status::ambiguous},
    {Check::contradiction, "contradiction", Status::ambiguous},
    {Check::running_ground, "running ground", Status::ambiguous},
    {Check::found_again, "found again", Status::ambiguous},
    {Check::rival, "rival motion", Status::ambiguous},
    {Check::uncertainty, "uncertainty", Status::weak},
};

}  // namespace

Status verdict(const Checks& checks) {
  for (const Rule& rule : kRules) {
    if (checks[rule.check].fails()) return rule.status;
  }
  return Status::valid;
}

const char* check_name(Check check) {
  for (const Rule& rule : kRules) {
    if (rule.check == check) return rule.name;
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
