// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/video/open_video.h"

#include <algorithm>
#include <array>
#include <dlfcn.h>
#include <filesystem>
#include <system_error>

namespace cliquevo::drivers {

namespace fs = std::filesystem;

// <prefix>/lib/cliquevo/modules/video.so for a program in <prefix>/bin or in <prefix>/libexec/cliquevo.
std::string video_module_path() {
  std::error_code ec;
  const fs::path bin = fs::read_symlink("/proc/self/exe", ec).parent_path();
  const fs::path place = "lib/cliquevo/modules/video.so";
  const fs::path elsewhere = bin.parent_path().parent_path() / place;
  return (fs::exists(elsewhere, ec) ? elsewhere : bin.parent_path() / place).string();
}

namespace {

struct Module {
  VideoOpenFunction* open = nullptr;
  std::optional<Error> error;
};

Module load_module() {
  const std::string path = video_module_path();
  std::error_code ec;
  if (!fs::exists(path, ec)) {
    return {nullptr, Error{"video files need a module that is not installed", path, "install cliquevo-tools"}};
  }
  void* library = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (library == nullptr) {
    const char* why = ::dlerror();
    return {nullptr, Error{"cannot load the module for video files", path, why != nullptr ? why : "install it again"}};
  }
  const auto version = reinterpret_cast<VideoInterfaceFunction*>(::dlsym(library, kVideoInterfaceName));
  const auto open = reinterpret_cast<VideoOpenFunction*>(::dlsym(library, kVideoOpenName));
  if (version == nullptr || open == nullptr || version() != kVideoInterface) {
    return {nullptr, Error{"module for video files is of another version", path, "install both of one version"}};
  }
  return {open, std::nullopt};  // never closed: readers are its objects
}

}  // namespace

bool is_video_name(const std::string& path) {
  static constexpr std::array kEndings{".mp4", ".mkv", ".avi", ".mov", ".webm", ".m4v"};
  std::string extension = fs::path(path).extension().string();
  for (char& c : extension) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  std::error_code ec;
  return std::find(kEndings.begin(), kEndings.end(), extension) != kEndings.end() && fs::is_regular_file(path, ec);
}

Result<std::unique_ptr<VideoReader>> open_video(const std::string& path) {
  static const Module module = load_module();
  if (module.error) return *module.error;
  std::unique_ptr<VideoReader> reader;
  Error error{"cannot open video", path, "see that it plays"};
  module.open(path, reader, error);
  if (reader == nullptr) return error;
  return reader;
}

}  // namespace cliquevo::drivers
