// SPDX-License-Identifier: BSD-3-Clause
// Where versions of libcamera differ (0.0.3 is Debian 12's).
#pragma once

#include <libcamera/libcamera.h>
#include <libcamera/version.h>

namespace cliquevo::drivers {

// generateConfiguration() takes a list of roles; later a span of them, which the same braces make.
inline std::unique_ptr<libcamera::CameraConfiguration> video_configuration(libcamera::Camera& camera) {
  return camera.generateConfiguration({libcamera::StreamRole::VideoRecording});
}

}  // namespace cliquevo::drivers
