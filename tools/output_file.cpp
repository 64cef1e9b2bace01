// SPDX-License-Identifier: BSD-3-Clause
#include "tools/output_file.h"

#include <cerrno>
#include <cstring>

namespace cliquevo::tools {

Result<OutputFile> OutputFile::open(const std::string& path, const std::string& kind) {
  OutputFile out;
  out.path_ = path;
  out.kind_ = kind;
  out.file_.reset(std::fopen(path.c_str(), "wb"));
  if (!out.file_) {
    return Error{"cannot write " + kind, path, std::string(std::strerror(errno)) + "; name a file that can be created"};
  }
  return out;
}

Result<void> OutputFile::write(std::span<const unsigned char> bytes) {
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) == bytes.size();
  const int write_error = errno;
  const bool closed = std::fclose(file_.release()) == 0;
  if (written && closed) return {};
  return Error{"cannot write " + kind_, path_,
               std::string(std::strerror(written ? errno : write_error)) + "; make room"};
}

Result<void> OutputFile::write(const std::string& text) {
  return write({reinterpret_cast<const unsigned char*>(text.data()), text.size()});
}

}  // namespace cliquevo::tools
