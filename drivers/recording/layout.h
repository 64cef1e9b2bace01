// SPDX-License-Identifier: BSD-3-Clause
// What a folder of recorded images holds, before any image is opened: the list of each eye's files, where times and
// calibration are. One finder a folder format.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/base/time.h"

namespace cliquevo::drivers {

struct EyeImage {
  std::string path;
  std::string name;  // without folder and extension
  std::optional<TimestampNs> stamp_ns;
};

struct Eye {
  std::string folder;
  std::vector<EyeImage> images;  // natural order of the names ("9" before "10")
};

struct Layout {
  std::string description;  // "KITTI odometry folder /data/06"
  std::string root;         // masks are looked for here
  Eye left;
  Eye right;
  int left_camera = 0;  // numbers in calibration files that hold more cameras
  int right_camera = 1;
  std::string calibration;  // file or folder; empty = none found
};

// Each: nothing when the folder is not of its format, an error when it is but is broken.
Result<std::optional<Layout>> find_euroc(const std::string& path);
Result<std::optional<Layout>> find_kitti_raw(const std::string& path);
Result<std::optional<Layout>> find_kitti_odometry(const std::string& path);
Result<std::optional<Layout>> find_two_folders(const std::string& path);

// The finders in turn; an error tells what was expected.
Result<Layout> find_layout(const std::string& path);

// Shared by the finders.

// Image files of a folder; an error when there is none, or two with the same name.
Result<Eye> list_eye(const std::string& folder);
// Both eyes; an error that names the missing one.
Result<void> list_eyes(Layout& layout, const std::string& left_folder, const std::string& right_folder);
// Whether the extension is one of an image.
bool is_image_name(const std::string& file);
bool natural_less(const std::string& a, const std::string& b);

}  // namespace cliquevo::drivers
