// SPDX-License-Identifier: BSD-3-Clause
// Bytes of a file by offset. No mapping: a file that shrinks meanwhile is an error of one read, not a signal.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "core/base/result.h"

namespace cliquevo::drivers {

class FileBytes {
 public:
  static Result<FileBytes> open(const std::string& path);
  FileBytes() = default;
  FileBytes(FileBytes&& other) noexcept;
  FileBytes& operator=(FileBytes&& other) noexcept;
  ~FileBytes();

  std::uint64_t size() const { return size_; }
  // false: not so many bytes there.
  bool read(std::uint64_t at, void* out, std::size_t count) const;

 private:
  int descriptor_ = -1;
  std::uint64_t size_ = 0;
};

}  // namespace cliquevo::drivers
