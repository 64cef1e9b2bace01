// SPDX-License-Identifier: BSD-3-Clause
// Where the stamps of recorded images come from: files of times, or the names of the images; and what becomes of
// stamps that do not rise.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "core/base/time.h"
#include "drivers/recording/layout.h"

namespace cliquevo::drivers {

// Reads the times file into the camera's images: by name where its rows name images (rows without image and images
// without a row are left out), else row by row (one row more or fewer than images is left out at the end, one image
// likewise). What was left out or concluded is added to `notes`. Error: other numbers of rows and images, no image of
// the names in the file.
Result<void> stamps_from_file(const std::string& path, ImageList& list, std::vector<std::string>& notes);

// Stamps from the images' names, where what differs between them is a time: since 1970, or whole numbers that come at
// an ordinary rate in ns, us or ms; a date, with dashes or without. False (and no change) when the names are no times.
bool stamps_from_names(ImageList& list, std::vector<std::string>& notes);

// The median step of rising stamps, ns; 100 ms where there is none.
std::int64_t period_of(const std::vector<TimestampNs>& stamps);

// The times file in a folder (times.txt, timestamps.csv, ..., in any case); empty = none.
std::string find_times(const std::string& folder);

// The file in a folder whose rows name most of this camera's images, whatever it is called; empty = none.
std::string find_image_list(const std::string& folder, const ImageList& list);

// Stamps in the order in which the pairs were recorded, made to rise.
struct RisingStamps {
  std::vector<TimestampNs> stamps_ns;
  std::vector<bool> skipped;        // pairs whose stamp steps back or repeats: not to be played
  std::vector<std::string> reason;  // why, for those
  std::int64_t skipped_count = 0;
};
// One stamp that is out of order costs its pair. Where the clock was set back for good, the first pair behind is
// skipped, and the stamps go on by the recorded steps. Error (naming `where`): more than half of the stamps are out of
// order.
Result<RisingStamps> make_rising(const std::vector<TimestampNs>& stamps_ns, const std::string& where);

}  // namespace cliquevo::drivers
