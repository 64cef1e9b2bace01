// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "core/base/result.h"
#include "drivers/frame_source.h"
#include "drivers/recording/recording_options.h"

namespace cliquevo::drivers {

struct VideoFiles {
  std::string left;   // or both pictures side by side
  std::string right;  // empty = side by side
  bool empty() const { return left.empty(); }
};

// The videos that a path means: a file; "LEFT,RIGHT"; a folder that holds one or two and no images. Empty = it means
// something else.
Result<VideoFiles> find_videos(const std::string& path);
Result<std::unique_ptr<FrameSource>> open_videos(const VideoFiles& files, const RecordingOptions& options);

}  // namespace cliquevo::drivers
