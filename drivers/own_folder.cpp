// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/own_folder.h"

#include <atomic>
#include <cerrno>
#include <cstring>
#include <dirent.h>
#include <fcntl.h>
#include <filesystem>
#include <functional>
#include <memory>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>

namespace cliquevo::drivers {

namespace {

constexpr mode_t kFolderMode = 0755;
constexpr mode_t kFileMode = 0644;

bool ours_alone(const struct stat& status) {
  return status.st_uid == ::geteuid() && (status.st_mode & (S_IWGRP | S_IWOTH)) == 0;
}

Error cannot(const std::string& what, const std::string& path, int error, const std::string& remedy) {
  return {fmt::format("{} ({})", what, std::strerror(error)), path, remedy};
}

// The folder, held open; -1: errno has the reason. Whatever the umask, others cannot write into what we make.
int open_or_make(int above, const char* name) {
  constexpr int kFlags = O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC;
  const int found = ::openat(above, name, kFlags);
  if (found >= 0 || errno != ENOENT) return found;
  // Of two that make it at once, one finds that it is there.
  if (::mkdirat(above, name, kFolderMode) != 0 && errno != EEXIST) return -1;
  return ::openat(above, name, kFlags);
}

// Nothing: it is ours alone.
std::optional<Error> objection(int descriptor, const std::string& path) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0) return cannot("cannot look at the folder", path, errno, "name another");
  if (status.st_uid != ::geteuid()) {
    return Error{fmt::format("the folder belongs to another user (uid {}, not {})", status.st_uid, ::geteuid()), path,
                 "name a folder of your own"};
  }
  if (!ours_alone(status)) {
    return Error{"others may write into the folder", path, "chmod go-w it, or name another"};
  }
  return std::nullopt;
}

Error not_opened(const std::string& path, int error) {
  if (error == ELOOP || error == ENOTDIR) return {"a link or a file, not a folder", path, "name the folder itself"};
  return cannot("cannot open or make the folder", path, error, "name one that you may write into");
}

std::size_t host_number() {
  char host[256] = {};
  ::gethostname(host, sizeof host - 1);
  return std::hash<std::string_view>{}(host);
}

bool write_all(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t done = ::write(descriptor, bytes.data(), bytes.size());
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(done));
  }
  return true;
}

}  // namespace

Result<OwnFolder> OwnFolder::open(const std::string& path) {
  std::error_code error;
  const std::filesystem::path above = std::filesystem::absolute(path, error).lexically_normal().parent_path();
  std::filesystem::create_directories(above, error);
  const int descriptor = open_or_make(AT_FDCWD, path.c_str());
  if (descriptor < 0) return not_opened(path, errno);
  OwnFolder out(descriptor, path);
  if (auto refused = objection(descriptor, path)) return *refused;
  return out;
}

Result<OwnFolder> OwnFolder::open_shared(const std::string& path) {
  auto own = open(path);
  if (own) return own;
  const int shared = ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (shared < 0) return own.error();
  const std::string name = fmt::format("user-{}", ::geteuid());
  const OwnFolder of_all(shared, path);
  return of_all.below(name);
}

OwnFolder::OwnFolder(OwnFolder&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), path_(std::move(other.path_)) {}

OwnFolder& OwnFolder::operator=(OwnFolder&& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(path_, other.path_);
  return *this;
}

OwnFolder::~OwnFolder() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Result<OwnFolder> OwnFolder::below(const std::string& name) const {
  const std::string path = path_ + "/" + name;
  const int descriptor = open_or_make(descriptor_, name.c_str());
  if (descriptor < 0) return not_opened(path, errno);
  OwnFolder out(descriptor, path);
  if (auto refused = objection(descriptor, path)) return *refused;
  return out;
}

// Non-blocking: of a pipe that somebody put there, open() would wait for a writer.
int OwnFolder::open_file(const std::string& name) const {
  const int file = ::openat(descriptor_, name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (file < 0) return -1;
  struct stat status {};
  if (::fstat(file, &status) == 0 && S_ISREG(status.st_mode) && ours_alone(status)) return file;
  ::close(file);
  return -1;
}

std::optional<std::string> OwnFolder::read(const std::string& name, std::size_t most) const {
  const int file = open_file(name);
  if (file < 0) return std::nullopt;
  std::optional<std::string> out;
  struct stat status {};
  if (::fstat(file, &status) == 0 && static_cast<std::uintmax_t>(status.st_size) <= most) {
    out.emplace(static_cast<std::size_t>(status.st_size), '\0');
    std::size_t got = 0;
    while (got < out->size()) {
      const ssize_t more = ::read(file, out->data() + got, out->size() - got);
      if (more < 0 && errno == EINTR) continue;
      if (more <= 0) break;
      got += static_cast<std::size_t>(more);
    }
    out->resize(got);
  }
  ::close(file);
  return out;
}

std::optional<std::int64_t> OwnFolder::written_ns(const std::string& name) const {
  struct stat status {};
  if (::fstatat(descriptor_, name.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0) return std::nullopt;
  if (!S_ISREG(status.st_mode) || !ours_alone(status)) return std::nullopt;
  return static_cast<std::int64_t>(status.st_mtim.tv_sec) * 1'000'000'000 + status.st_mtim.tv_nsec;
}

Result<void> OwnFolder::write(const std::string& name, std::string_view bytes) const {
  static std::atomic<std::uint64_t> count{0};
  // The host's number keeps machines apart that share the storage and count processes alike.
  const std::string temporary = fmt::format("{}.{}.{}.{}", name, host_number(), ::getpid(), count++);
  const auto fail = [&](int error) {
    ::unlinkat(descriptor_, temporary.c_str(), 0);
    return cannot("cannot write", path_ + "/" + name, error,
                  error == ENOSPC || error == EDQUOT ? "make room" : "see who may write there");
  };
  const int file =
      ::openat(descriptor_, temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, kFileMode);
  if (file < 0) return fail(errno);
  // A file is read by us only when no other may write it, whatever umask is in force.
  const bool written = ::fchmod(file, kFileMode) == 0 && write_all(file, bytes);
  const int write_error = errno;
  if (::close(file) != 0 && written) return fail(errno);  // network storage reports only here that it is full
  if (!written) return fail(write_error);
  if (::renameat(descriptor_, temporary.c_str(), descriptor_, name.c_str()) != 0) return fail(errno);
  return {};
}

Result<void> OwnFolder::write(const std::string& name, std::span<const std::uint8_t> bytes) const {
  return write(name, std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
}

void OwnFolder::touch(const std::string& name) const {
  ::utimensat(descriptor_, name.c_str(), nullptr, AT_SYMLINK_NOFOLLOW);
}

void OwnFolder::remove(const std::string& name) const { ::unlinkat(descriptor_, name.c_str(), 0); }

std::vector<std::string> OwnFolder::names() const {
  std::vector<std::string> out;
  const int again = ::openat(descriptor_, ".", O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (again < 0) return out;
  const std::unique_ptr<DIR, int (*)(DIR*)> folder(::fdopendir(again), &::closedir);
  if (folder == nullptr) {
    ::close(again);
    return out;
  }
  while (const dirent* entry = ::readdir(folder.get())) {
    const std::string name = entry->d_name;
    if (name != "." && name != "..") out.push_back(name);
  }
  return out;
}

}  // namespace cliquevo::drivers
