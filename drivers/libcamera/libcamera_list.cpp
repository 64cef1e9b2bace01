// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/libcamera.h"
#include "drivers/libcamera/libcamera_camera.h"

namespace cliquevo::drivers {

std::vector<SeenCamera> list_libcamera() {
  std::vector<SeenCamera> out;
  libcamera::CameraManager* manager = camera_manager();
  if (manager == nullptr) return out;
  for (const auto& camera : manager->cameras()) {
    SeenCamera seen{"libcamera", camera->id(), "", {}};
    const auto model = camera->properties().get(libcamera::properties::Model);
    seen.description = model ? *model : std::string("camera");
    if (const auto configuration = video_configuration(*camera); configuration && !configuration->empty()) {
      for (const auto& format : configuration->at(0).formats().pixelformats())
        seen.formats.push_back(format.toString());
    }
    out.push_back(std::move(seen));
  }
  return out;
}

}  // namespace cliquevo::drivers
