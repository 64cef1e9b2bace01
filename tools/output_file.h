// SPDX-License-Identifier: BSD-3-Clause
// A file that is written at the end of a long run, but opened at its start: a bad path shows before the work, not
// after.
#pragma once

#include <cstdio>
#include <memory>
#include <span>
#include <string>

#include "core/base/result.h"

namespace cliquevo::tools {

class OutputFile {
 public:
  // Creates or truncates. `kind` is for messages: "plot".
  static Result<OutputFile> open(const std::string& path, const std::string& kind);
  // Once, the whole content; the file is closed after it.
  Result<void> write(std::span<const unsigned char> bytes);
  Result<void> write(const std::string& text);

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  OutputFile() = default;
  std::string path_;
  std::string kind_;
  std::unique_ptr<std::FILE, Close> file_;
};

}  // namespace cliquevo::tools
