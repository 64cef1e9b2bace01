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
#ifdef CLIQUEVO_ARAVIS
      {"aravis", "GigE Vision and USB3 Vision, through Aravis", drivers::open_aravis, drivers::list_aravis},
#else
      {"aravis", "GigE Vision and USB3 Vision, through Aravis", nullptr, nullptr},
#endif
#ifdef CLIQUEVO_V4L2
      {"v4l2", "Video4Linux", drivers::open_v4l2, drivers::list_v4l2},
#else
      {"v4l2", "Video4Linux", nullptr, nullptr},
#endif
#ifdef CLIQUEVO_LIBCAMERA
      {"libcamera", "libcamera", drivers::open_libcamera, drivers::list_libcamera},
#else
      {"libcamera", "libcamera", nullptr, nullptr},
#endif
  };
  return families;
}

}  // namespace cliquevo::daemon
