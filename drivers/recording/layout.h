// SPDX-License-Identifier: BSD-3-Clause
// What a folder of recorded images holds, before any image is opened: the list of each camera's files, where times and
// calibration are. One finder a folder format.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/base/time.h"

namespace cliquevo::drivers {

struct RecordedImage {
  std::string path;
  std::string name;  // without folder and extension
  std::optional<TimestampNs> stamp_ns;
};

struct ImageList {
  std::string folder;
  std::vector<RecordedImage> images;  // natural order of the names ("9" before "10")
};

// Whether the images of both have the same names, one by one.
bool same_names(const ImageList& a, const ImageList& b);

struct Layout {
  std::string description;  // "KITTI odometry folder /data/06"
  std::string root;         // masks are looked for here
  ImageList left;
  ImageList right;
  int left_camera = 0;  // numbers in calibration files that hold more cameras
  int right_camera = 1;
  std::string calibration;         // file or folder; empty = none found
  bool side_by_side = false;       // one file a pair, left half and right half; then `right` is as `left`
  std::vector<std::string> notes;  // what was concluded, left out or chosen, for the user to know
};

// One file a pair, left half and right half, because the user says so.
Result<Layout> read_side_by_side(const std::string& path);

struct LayoutKind {
  const char* looks_like;  // for the message where none fits
  // Nothing when the folder is not of this kind, an error when it is but is broken.
  Result<std::optional<Layout>> (*find)(const std::string& path);
};
// The layouts, in the order in which they are tried.
const std::vector<LayoutKind>& layout_kinds();

// The first of them that fits; an error lists what was looked for and what is there. side_by_side: stated by the user.
Result<Layout> find_layout(const std::string& path, bool side_by_side = false);

// Shared by the finders.

// Image files of a folder; an error when there is none, or two with the same name.
Result<ImageList> list_images(const std::string& folder);
// Both lists; an error that names the missing one.
Result<void> list_both_sides(Layout& layout, const std::string& left_folder, const std::string& right_folder);
// Stamps for both cameras of a layout: from the times file of each, else from one for both in their common folder or
// above it up to `top`, else from the names.
Result<void> find_stamps(Layout& layout, const std::string& top);
// The calibration in one of the folders from `folder` up to `top`, or in their folders for such files.
std::string calibration_between(const std::string& folder, const std::string& top);
// Whether the extension is one of an image.
bool is_image_name(const std::string& file);
bool natural_less(const std::string& a, const std::string& b);

// A folder with images, somewhere below another.
struct ImageFolder {
  std::vector<std::string> parts;  // of its path below the other; empty = that folder itself
  std::string path;
};
// At most `depth` levels down, in natural order; hidden folders are left out.
std::vector<ImageFolder> folders_with_images(const std::string& path, int depth);

}  // namespace cliquevo::drivers
