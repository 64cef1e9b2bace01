// SPDX-License-Identifier: BSD-3-Clause
#include "tools/picture_format.h"

#include <algorithm>
#include <cctype>

namespace cliquevo::tools {

std::optional<PictureFormat> picture_format(std::string_view path) {
  std::string ending(path.substr(std::min(path.size(), path.find_last_of("./") + 1)));
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  if (ending == "png") return PictureFormat::png;
  if (ending == "svg") return PictureFormat::svg;
  if (ending == "pdf") return PictureFormat::pdf;
  return std::nullopt;
}

Result<PictureFormat> plot_format(const std::string& path) {
  const auto format = picture_format(path);
  if (format) return *format;
  if (path.find('.', path.find_last_of('/') + 1) == std::string::npos) return PictureFormat::png;
  return Error{"wrong usage", "--plot " + path, "name a file that ends in .png, .svg or .pdf"};
}

}  // namespace cliquevo::tools
