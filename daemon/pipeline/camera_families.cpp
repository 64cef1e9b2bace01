// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/camera_families.h"

#ifdef CLIQUEVO_ARAVIS
#include "drivers/aravis.h"
#endif
#ifdef CLIQUEVO_V4L2
#include "drivers/v4l2.h"
#endif
#ifdef CLIQUEVO_LIBCAMERA
#include "drivers/libcamera.h"
#endif

namespace cliquevo::daemon {

const std::vector<CameraFamily>& camera_families() {
  static const std::vector<CameraFamily> families{
      {"aravis", "GigE Vision and USB3 Vision, through Aravis",
#ifdef CLIQUEVO_ARAVIS
       drivers::open_aravis, drivers::list_aravis
#endif
      },
      {"v4l2", "Video4Linux",
#ifdef CLIQUEVO_V4L2
       drivers::open_v4l2, drivers::list_v4l2
#endif
      },
      {"libcamera", "libcamera",
#ifdef CLIQUEVO_LIBCAMERA
       drivers::open_libcamera, drivers::list_libcamera
#endif
      },
  };
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
