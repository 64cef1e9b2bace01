// SPDX-License-Identifier: BSD-3-Clause
// The camera families, a row each: name (source.type), how a pair is opened, how cameras are listed.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "drivers/frame_source.h"
#include "drivers/live/camera_options.h"

namespace cliquevo::daemon {

struct CameraFamily {
  const char* name;
  const char* meaning;  // for people
  // Null where the family's library was not found at build time.
  Result<std::unique_ptr<drivers::FrameSource>> (*open)(const drivers::CameraOptions&, drivers::OpenTrouble&) = nullptr;
  std::vector<drivers::SeenCamera> (*list)() = nullptr;

  bool is_built_in() const { return open != nullptr; }
};

const std::vector<CameraFamily>& camera_families();
// "aravis, v4l2": those of this build; empty where there is none.
std::string built_in_families();

}  // namespace cliquevo::daemon
