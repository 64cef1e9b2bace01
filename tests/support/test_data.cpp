// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/test_data.h"

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <unistd.h>
#include <vector>

#if defined(__has_feature)
#if __has_feature(thread_sanitizer)
#define CLIQUEVO_THREAD_SANITIZER
#endif
#if __has_feature(address_sanitizer)
#define CLIQUEVO_ADDRESS_SANITIZER
#endif
#elif defined(__SANITIZE_THREAD__)
#define CLIQUEVO_THREAD_SANITIZER
#elif defined(__SANITIZE_ADDRESS__)
#define CLIQUEVO_ADDRESS_SANITIZER
#endif

#ifdef CLIQUEVO_THREAD_SANITIZER
// OpenCV, with which tests compare, initialises GDAL with its codecs: that takes two of its locks in either order, in
// one thread.
extern "C" __attribute__((weak, no_sanitize_thread)) const char* __tsan_default_suppressions();  // NOLINT
extern "C" const char* __tsan_default_suppressions() { return "deadlock:libgdal\n"; }            // NOLINT
#endif

#ifdef CLIQUEVO_ADDRESS_SANITIZER
// fontconfig, which finds the font of a chart, keeps what it has read until the process ends.
extern "C" __attribute__((weak, no_sanitize_address)) const char* __lsan_default_suppressions();  // NOLINT
extern "C" const char* __lsan_default_suppressions() { return "leak:libfontconfig\n"; }           // NOLINT
#endif

namespace cliquevo::test {

namespace fs = std::filesystem;

std::string data_dir() {
  const char* set = std::getenv("CLIQUEVO_DATA");
  return set != nullptr && *set != '\0' ? set : CLIQUEVO_DEFAULT_DATA;
}

bool have_data(const std::string& name) { return fs::exists(fs::path(data_dir()) / name); }

std::string field_dir() {
  const char* set = std::getenv("CLIQUEVO_FIELD");
  return set != nullptr && *set != '\0' ? set : CLIQUEVO_DEFAULT_FIELD;
}

bool have_field(const std::string& name) { return fs::exists(fs::path(field_dir()) / name); }

std::string binary(const std::string& name) { return std::string(CLIQUEVO_BIN_DIR) + "/" + name; }

std::string scratch_dir() {
  struct Root {
    fs::path path = fs::temp_directory_path() / ("cliquevo_test_" + std::to_string(::getpid()));
    ~Root() {
      std::error_code ignored;
      fs::remove_all(path, ignored);
    }
  };
  static Root root;
  static std::atomic<int> count{0};
  const fs::path dir = root.path / std::to_string(count++);
  fs::create_directories(dir);
  return dir.string();
}

}  // namespace cliquevo::test
