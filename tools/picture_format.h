// SPDX-License-Identifier: BSD-3-Clause
// Kinds of picture files, by the ending of a name.
#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace cliquevo::tools {

enum class PictureFormat { png, svg, pdf };
// By the ending of a file's name, in any case; none: it is none of these.
std::optional<PictureFormat> picture_format(std::string_view path);
// What --plot may be called; an error is one of usage.
Result<PictureFormat> plot_format(const std::string& path);

}  // namespace cliquevo::tools
