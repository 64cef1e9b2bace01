// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/images/masks.h"

#include <filesystem>

#include <fmt/format.h>

#include "drivers/images/image_reader.h"

namespace cliquevo::drivers {

namespace {

Result<void> read_mask(const std::string& given, const std::string& root, const char* name, SourceInfo& info,
                       Image<std::uint8_t>& mask) {
  std::error_code ec;
  std::string path = given;
  if (path.empty()) {
    if (root.empty()) return {};
    path = (std::filesystem::path(root) / name).string();
    if (!std::filesystem::exists(path, ec)) return {};
  }
  ImageReader reader;
  if (auto ok = reader.read(path, mask); !ok) {
    return Error{"cannot read mask", path, ok.error().remedy};
  }
  if (mask.width() != info.width || mask.height() != info.height) {
    return Error{"mask has another size than the images", path,
                 fmt::format("it is {}x{}, the images are {}x{}: draw it on an image of this recording", mask.width(),
                             mask.height(), info.width, info.height)};
  }
  return {};
}

}  // namespace

Result<void> read_masks(const std::string& left, const std::string& right, const std::string& root, SourceInfo& info) {
  if (auto ok = read_mask(left, root, "mask_left.png", info, info.left_mask); !ok) return ok;
  return read_mask(right, root, "mask_right.png", info, info.right_mask);
}

}  // namespace cliquevo::drivers
