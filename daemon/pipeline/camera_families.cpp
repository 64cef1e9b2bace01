// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/camera_families.h"

#include "drivers/camera_family_table.h"

namespace cliquevo::daemon {

const std::vector<CameraFamily>& camera_families() {
  static const std::vector<CameraFamily> families{CLIQUEVO_CAMERA_FAMILIES};
  return families;
}

std::string built_in_families() {
  std::string out;
  for (const CameraFamily& family : camera_families()) {
    if (family.is_built_in()) out += (out.empty() ? "" : ", ") + std::string(family.name);
  }
  return out;
}

}  // namespace cliquevo::daemon
