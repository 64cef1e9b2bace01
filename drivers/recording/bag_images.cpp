// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recording/bag_images.h"

#include <utility>

#include "core/base/printable.h"
#include "drivers/bags/ros_images.h"
#include "drivers/images/decode_image.h"
#include "drivers/images/sample_depth.h"

namespace cliquevo::drivers {

namespace {

Error broken(const std::string& name) {
  return {"cannot read image", name, "copy the bag again: the message is damaged"};
}

}  // namespace

Result<const GreyPicture*> BagImages::read_as_stored(BagSet& bags, const SetMessage& message, const std::string& name) {
  if (auto ok = bags.read(message, bytes_); !ok) return ok.error();
  const BagTopic& topic = bags.topic_of(message);
  std::string bad;
  if (topic.type == kCompressedImageType) {
    const auto parsed = parse_compressed_image(bytes_, topic.serialization);
    if (!parsed) return broken(name);
    said_mosaic_ = false;
    bad = decode_image(parsed->data, picture_);
    if (!bad.empty()) bad += " (format " + printable(std::string(parsed->format.substr(0, 40))) + ")";
  } else {
    const auto parsed = parse_image(bytes_, topic.serialization);
    if (!parsed) return broken(name);
    said_mosaic_ = is_mosaic_encoding(parsed->encoding);
    bad = to_grey(*parsed, picture_);
    if (!bad.empty()) bad += " (encoding " + printable(std::string(parsed->encoding.substr(0, 40))) + ")";
  }
  if (!bad.empty()) return Error{"cannot read image", name, bad};
  if (picture_.warnings > 0) ++warned_;
  return &picture_;
}

Result<void> BagImages::read(BagSet& bags, const SetMessage& message, const std::string& name,
                             Image<std::uint8_t>& image) {
  // The image's own memory is decoded into.
  std::swap(image, picture_.bytes);
  const auto done = read_as_stored(bags, message, name);
  std::swap(image, picture_.bytes);
  if (!done) return done.error();
  if (picture_.deep) {
    SampleDepth depth;
    if (!shift_) depth.add(picture_);
    shift_to_bytes(picture_.words.cview(), shift_.value_or(depth.shift()), image);
  }
  if (mosaic_) to_grey_.convert(image.view());
  return {};
}

}  // namespace cliquevo::drivers
