// SPDX-License-Identifier: BSD-3-Clause
// Opens video files through the module that decodes them.
#pragma once

#include <memory>
#include <string>

#include "core/base/result.h"
#include "drivers/video/video_reader.h"

namespace cliquevo::drivers {

// Whether it is a file whose name ends as that of a video.
bool is_video_name(const std::string& path);

// Where the module lies, or would lie.
std::string video_module_path();

// An error where the module is not installed, or the file cannot be read.
Result<std::unique_ptr<VideoReader>> open_video(const std::string& path);

}  // namespace cliquevo::drivers
