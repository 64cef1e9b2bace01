// SPDX-License-Identifier: BSD-3-Clause
#include "tools/fleet/fingerprint.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fcntl.h>
#include <filesystem>
#include <sys/stat.h>
#include <system_error>
#include <unistd.h>
#include <vector>

#include <fmt/format.h>

#include "tools/fleet/digest.h"

namespace cliquevo::tools::fleet {

namespace {

namespace fs = std::filesystem;

constexpr std::size_t kSampledFiles = 16;
constexpr std::int64_t kBlock = 4096;        // bytes
constexpr std::int64_t kBlocksOfAFile = 16;  // at even distances, the last one at its end

struct File {
  std::string name;  // from the recording's folder
  std::string path;
  std::int64_t bytes = 0;
  std::int64_t time_ns = 0;
};

Error unreadable(const std::string& path, int error) {
  return {fmt::format("cannot read the recording ({})", std::strerror(error)), path,
          "see that it is there, and mounted on this machine"};
}

Result<File> look_at(const std::string& path, const std::string& name) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return unreadable(path, errno);
  return File{name, path, status.st_size,
              static_cast<std::int64_t>(status.st_mtim.tv_sec) * 1'000'000'000 + status.st_mtim.tv_nsec};
}

Result<void> list_folder(const std::string& recording, std::vector<File>& out) {
  std::error_code error;
  // Links are followed, as the reader of recordings does; one in a circle ends at the depth that no layout has.
  constexpr int kDeepest = 12;
  fs::recursive_directory_iterator entry(recording, fs::directory_options::follow_directory_symlink, error);
  for (const fs::recursive_directory_iterator end; !error && entry != end; entry.increment(error)) {
    if (entry.depth() >= kDeepest) entry.disable_recursion_pending();
    std::error_code none;
    if (!entry->is_regular_file(none)) continue;
    auto file = look_at(entry->path().string(), entry->path().lexically_relative(recording).string());
    if (!file) return file.error();
    out.push_back(std::move(*file));
  }
  if (error) return unreadable(recording, error.value());
  return {};
}

Result<std::vector<File>> files_of(const std::string& recording) {
  std::vector<File> out;
  std::error_code none;
  if (fs::is_directory(recording, none)) {
    if (auto listed = list_folder(recording, out); !listed) return listed.error();
    std::sort(out.begin(), out.end(), [](const File& a, const File& b) { return a.name < b.name; });
    return out;
  }
  // LEFT,RIGHT, unless a file has that very name.
  const std::size_t comma = fs::exists(recording, none) ? std::string::npos : recording.find(',');
  for (std::size_t begin = 0; begin < recording.size();) {
    const std::size_t end =
        comma == std::string::npos ? recording.size() : std::min(recording.find(',', begin), recording.size());
    const std::string path = recording.substr(begin, end - begin);
    auto file = look_at(path, fs::path(path).filename().string());
    if (!file) return file.error();
    out.push_back(std::move(*file));
    begin = end + 1;
  }
  return out;
}

Result<void> sample(const File& file, std::int64_t blocks, Digest& digest) {
  const int descriptor = ::open(file.path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return unreadable(file.path, errno);
  char block[kBlock];
  Result<void> out;
  for (std::int64_t k = 0; k < blocks; ++k) {
    const std::int64_t last = std::max<std::int64_t>(0, file.bytes - kBlock);
    const ssize_t got = ::pread(descriptor, block, sizeof block, last * k / std::max<std::int64_t>(1, blocks - 1));
    if (got < 0) out = unreadable(file.path, errno);
    if (got <= 0) break;
    digest.add({block, static_cast<std::size_t>(got)});
  }
  ::close(descriptor);
  return out;
}

}  // namespace

Result<Fingerprint> fingerprint_of(const std::string& recording) {
  const auto files = files_of(recording);
  if (!files) return files.error();
  if (files->empty()) return unreadable(recording, ENOENT);
  Fingerprint out;
  Digest digest;
  for (const File& file : *files) {
    digest.field("file", file.name).field("bytes", fmt::format("{}", file.bytes));
    digest.field("time", fmt::format("{}", file.time_ns));
    out.bytes += file.bytes;
  }
  out.files = static_cast<std::int64_t>(files->size());
  const std::size_t sampled = std::min(files->size(), kSampledFiles);
  const std::int64_t blocks = std::max<std::int64_t>(1, kBlocksOfAFile * 2 / static_cast<std::int64_t>(sampled));
  for (std::size_t k = 0; k < sampled; ++k) {
    const std::size_t at = sampled == 1 ? 0 : k * (files->size() - 1) / (sampled - 1);
    if (auto done = sample((*files)[at], blocks, digest); !done) return done.error();
  }
  out.digest = digest.hex();
  return out;
}

}  // namespace cliquevo::tools::fleet
