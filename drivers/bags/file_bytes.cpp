// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/bags/file_bytes.h"

#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <utility>

namespace cliquevo::drivers {

Result<FileBytes> FileBytes::open(const std::string& path) {
  FileBytes out;
  out.descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  struct stat status {};
  if (out.descriptor_ < 0 || ::fstat(out.descriptor_, &status) != 0) {
    return Error{"cannot open file", path, std::strerror(errno)};
  }
  if (!S_ISREG(status.st_mode)) return Error{"cannot open file", path, "it is not a regular file"};
  out.size_ = static_cast<std::uint64_t>(status.st_size);
  return out;
}

FileBytes::FileBytes(FileBytes&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), size_(other.size_) {}

FileBytes& FileBytes::operator=(FileBytes&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(size_, other.size_);
  return *this;
}

FileBytes::~FileBytes() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

bool FileBytes::read(std::uint64_t at, void* out, std::size_t count) const {
  if (at > size_ || count > size_ - at) return false;
  auto* to = static_cast<char*>(out);
  while (count > 0) {
    const ssize_t got = ::pread(descriptor_, to, count, static_cast<off_t>(at));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return false;
    to += got;
    at += static_cast<std::uint64_t>(got);
    count -= static_cast<std::size_t>(got);
  }
  return true;
}

}  // namespace cliquevo::drivers
