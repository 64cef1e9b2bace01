// SPDX-License-Identifier: BSD-3-Clause
// The page's own files, which are part of the program: nothing else can be requested.
#pragma once

#include <string_view>
#include <vector>

namespace cliquevo::view {

struct PageFile {
  std::string_view path;  // "/main.js"
  std::string_view type;  // "text/javascript; charset=utf-8"
  std::string_view content;
};

const std::vector<PageFile>& page_files();
// nullptr: there is none of this name. "/" is the page itself.
const PageFile* find_page_file(std::string_view path);

}  // namespace cliquevo::view
