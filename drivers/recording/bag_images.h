// SPDX-License-Identifier: BSD-3-Clause
// Images of a bag's messages to grey 8-bit images, compressed or not.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/bags/ros_messages.h"
#include "drivers/images/bayer.h"
#include "drivers/images/grey_picture.h"
#include "drivers/recording/bag_set.h"

namespace cliquevo::drivers {

class BagImages {
 public:
  // As stored; the picture is valid until the next call.
  Result<const GreyPicture*> read_as_stored(BagSet& bags, const SetMessage& message, const std::string& name);
  // Samples of more than 8 bits are shifted down; mosaics become grey where set_mosaic() says so.
  Result<void> read(BagSet& bags, const SetMessage& message, const std::string& name, Image<std::uint8_t>& image);
  void set_shift(int shift) { shift_ = shift; }
  void set_mosaic(bool mosaic) { mosaic_ = mosaic; }
  // Whether the last message said that it is a mosaic.
  bool said_mosaic() const { return said_mosaic_; }
  std::int64_t warned() const { return warned_; }

 private:
  std::vector<std::uint8_t> bytes_;
  GreyPicture picture_;
  std::optional<int> shift_;
  MosaicToGrey to_grey_;
  bool mosaic_ = false;
  bool said_mosaic_ = false;
  std::int64_t warned_ = 0;
};

}  // namespace cliquevo::drivers
