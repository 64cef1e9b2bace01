# SPDX-License-Identifier: BSD-3-Clause
# Writes a source that takes the page's files into the program, byte for byte.
set(page ${CMAKE_CURRENT_SOURCE_DIR}/page)
file(GLOB_RECURSE files CONFIGURE_DEPENDS RELATIVE ${page}
  ${page}/*.html ${page}/*.js ${page}/*.css ${page}/*.svg)
list(SORT files)
set(assembly "")
set(declarations "")
set(entries "")
set(sources "")
foreach(file ${files})
  string(MAKE_C_IDENTIFIER ${file} name)
  get_filename_component(ending ${file} LAST_EXT)
  if(ending STREQUAL ".js")
    set(type "text/javascript; charset=utf-8")
  elseif(ending STREQUAL ".css")
    set(type "text/css; charset=utf-8")
  elseif(ending STREQUAL ".svg")
    set(type "image/svg+xml")
  else()
    set(type "text/html; charset=utf-8")
  endif()
  string(APPEND assembly
    "    \"page_${name}:\\n.incbin \\\"${page}/${file}\\\"\\npage_${name}_end:\\n\"\n")
  string(APPEND declarations "extern const char page_${name}[] __asm__(\"page_${name}\");\n"
    "extern const char page_${name}_end[] __asm__(\"page_${name}_end\");\n")
  string(APPEND entries "      {\"/${file}\", \"${type}\", {page_${name}, static_cast<std::size_t>(page_${name}_end - page_${name})}},\n")
  list(APPEND sources ${page}/${file})
endforeach()
set(generated ${CMAKE_CURRENT_BINARY_DIR}/page_files.cpp)
file(CONFIGURE OUTPUT ${generated} @ONLY CONTENT [[
// Written by tools/view/page_files.cmake.
#include "tools/view/page_files.h"

__asm__(
    ".section .rodata\n"
@assembly@    ".previous\n");
extern "C" {
@declarations@}

namespace cliquevo::view {

const std::vector<PageFile>& page_files() {
  static const std::vector<PageFile> files = {
@entries@  };
  return files;
}

const PageFile* find_page_file(std::string_view path) {
  if (path == "/") path = "/index.html";
  for (const PageFile& file : page_files()) {
    if (file.path == path) return &file;
  }
  return nullptr;
}

}  // namespace cliquevo::view
]])
set_source_files_properties(${generated} PROPERTIES OBJECT_DEPENDS "${sources}")
