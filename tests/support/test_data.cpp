// SPDX-License-Identifier: BSD-3-Clause
#include "tests/support/test_data.h"

#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <unistd.h>
#include <vector>

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
