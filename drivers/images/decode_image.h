// SPDX-License-Identifier: BSD-3-Clause
// Image files to grey pictures: PNG, JPEG, PGM/PPM, TIFF and BMP, recognised by their first bytes.
#pragma once

#include <string>

#include "drivers/images/grey_picture.h"

namespace cliquevo::drivers {

// Decodes `file` into `picture`, whose memory is reused. Returns why it cannot be taken, as what the user should do
// ("copy the recording again: the file is torn"); empty = done. A file that lacks pixels is never taken.
std::string decode_image(Bytes file, GreyPicture& picture);

// One row a format: how it is recognised and decoded.
struct ImageFormat {
  const char* name;
  bool (*recognises)(Bytes file);
  std::string (*decode)(Bytes file, GreyPicture& picture);
};
std::span<const ImageFormat> image_formats();

bool is_png(Bytes file);
std::string decode_png(Bytes file, GreyPicture& picture);
bool is_jpeg(Bytes file);
std::string decode_jpeg_file(Bytes file, GreyPicture& picture);
bool is_netpbm(Bytes file);
std::string decode_netpbm(Bytes file, GreyPicture& picture);
bool is_tiff(Bytes file);
std::string decode_tiff(Bytes file, GreyPicture& picture);
bool is_bmp(Bytes file);
std::string decode_bmp(Bytes file, GreyPicture& picture);

inline constexpr const char* kTorn = "copy the recording again: the file is torn";

}  // namespace cliquevo::drivers
