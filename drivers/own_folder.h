// SPDX-License-Identifier: BSD-3-Clause
// A folder of files that nobody but this user can have written, for caches on storage that several users share: what
// is read from it needs no distrust. Everything goes through the open folder itself (openat), so that nobody can put
// another in its place meanwhile, and no link is followed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace cliquevo::drivers {

class OwnFolder {
 public:
  // Opens the folder, and makes it where there is none (mode 0755; folders above it too). Refused: a link, a folder of
  // another user's, and one that group or others may write into. Folders above it may be links.
  static Result<OwnFolder> open(const std::string& path);
  // The same where others work in `path` too: one that is not ours alone is left to them, and ours is the folder
  // user-UID in it.
  static Result<OwnFolder> open_shared(const std::string& path);

  OwnFolder(OwnFolder&& other) noexcept;
  OwnFolder& operator=(OwnFolder&& other) noexcept;
  ~OwnFolder();

  const std::string& path() const { return path_; }
  // The folder `name` in it, held to the same; made where there is none.
  Result<OwnFolder> below(const std::string& name) const;

  // A file's bytes; nothing: there is no such file, or it is none that we wrote (a link, another owner, writable by
  // others, no regular file), or it has more than `most` bytes.
  std::optional<std::string> read(const std::string& name, std::size_t most) const;
  // The time at which such a file was written, ns since 1970; nothing: as read().
  std::optional<std::int64_t> written_ns(const std::string& name) const;
  // The whole file or nothing, whoever reads meanwhile and whatever ends the program: under another name first.
  // Error: no space, no right; names the file.
  Result<void> write(const std::string& name, std::string_view bytes) const;
  Result<void> write(const std::string& name, std::span<const std::uint8_t> bytes) const;
  // Sets its time to now.
  void touch(const std::string& name) const;
  void remove(const std::string& name) const;
  // All there is in it, in no order.
  std::vector<std::string> names() const;

 private:
  OwnFolder(int descriptor, std::string path) : descriptor_(descriptor), path_(std::move(path)) {}
  int open_file(const std::string& name) const;

  int descriptor_ = -1;
  std::string path_;
};

}  // namespace cliquevo::drivers
