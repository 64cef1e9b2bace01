// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/calibration/zip_archive.h"

#include <cstdint>
#include <utility>
#include <zlib.h>

#include <fmt/format.h>

#include "drivers/text_file.h"

namespace cliquevo::drivers {

namespace {

constexpr std::string_view kMemberMark("PK\3\4", 4);
constexpr std::string_view kDirectoryMark("PK\1\2", 4);
constexpr std::string_view kEndMark("PK\5\6", 4);
constexpr std::size_t kMemberHead = 30;
constexpr std::size_t kDirectoryHead = 46;
constexpr std::size_t kEndHead = 22;
constexpr std::size_t kMostComment = 65535;  // behind the end's head

std::uint32_t little_endian(std::string_view bytes, std::size_t at, int count) {
  std::uint32_t out = 0;
  for (int i = count; i-- > 0;) out = out << 8U | static_cast<unsigned char>(bytes[at + static_cast<std::size_t>(i)]);
  return out;
}

Error torn_zip(const std::string& path, const std::string& what) {
  return {fmt::format("calibration is a torn archive ({})", what), path, "copy it again, or write it anew"};
}

// A row of the directory at the archive's end.
struct ZipRow {
  std::string name;
  std::uint32_t flags = 0;
  std::uint32_t method = 0;
  std::uint32_t checksum = 0;
  std::size_t packed = 0;
  std::size_t size = 0;
  std::size_t at = 0;  // of the member's head
};

// The row at `at`, which moves on behind it; false: torn.
bool read_row(std::string_view bytes, std::size_t& at, ZipRow& row) {
  if (at > bytes.size() || bytes.size() - at < kDirectoryHead || bytes.substr(at, 4) != kDirectoryMark) return false;
  row.flags = little_endian(bytes, at + 8, 2);
  row.method = little_endian(bytes, at + 10, 2);
  row.checksum = little_endian(bytes, at + 16, 4);
  row.packed = little_endian(bytes, at + 20, 4);
  row.size = little_endian(bytes, at + 24, 4);
  row.at = little_endian(bytes, at + 42, 4);
  const std::size_t name = little_endian(bytes, at + 28, 2);
  const std::size_t rest = little_endian(bytes, at + 30, 2) + little_endian(bytes, at + 32, 2);
  if (bytes.size() - at - kDirectoryHead < name + rest) return false;
  row.name = std::string(bytes.substr(at + kDirectoryHead, name));
  at += kDirectoryHead + name + rest;
  return true;
}

bool inflate_whole(std::string_view packed, std::string& out) {
  z_stream stream{};
  constexpr int kNoHead = -15;
  if (inflateInit2(&stream, kNoHead) != Z_OK) return false;
  // zlib reads them only.
  stream.next_in = const_cast<Bytef*>(reinterpret_cast<const Bytef*>(packed.data()));
  stream.avail_in = static_cast<uInt>(packed.size());
  stream.next_out = reinterpret_cast<Bytef*>(out.data());
  stream.avail_out = static_cast<uInt>(out.size());
  const int state = inflate(&stream, Z_FINISH);
  const bool whole = state == Z_STREAM_END && stream.avail_out == 0;
  inflateEnd(&stream);
  return whole;
}

Result<ZipMember> read_member(std::string_view bytes, const ZipRow& row, const std::string& path) {
  const std::string shown = printable(row.name.substr(0, 64));
  if ((row.flags & 1U) != 0 || (row.method != 0 && row.method != 8)) {
    return Error{"archive is encrypted, or packed in an unknown way", fmt::format("{} ({})", path, shown),
                 "write it with np.savez"};
  }
  if (row.at > bytes.size() || bytes.size() - row.at < kMemberHead || bytes.substr(row.at, 4) != kMemberMark) {
    return torn_zip(path, shown);
  }
  // The head has its own count of extra bytes; its sizes may stand behind the data.
  const std::size_t begin =
      row.at + kMemberHead + little_endian(bytes, row.at + 26, 2) + little_endian(bytes, row.at + 28, 2);
  if (begin > bytes.size() || bytes.size() - begin < row.packed) return torn_zip(path, shown);
  const std::string_view packed = bytes.substr(begin, row.packed);
  ZipMember out;
  out.name = row.name;
  if (row.method == 0) {
    if (row.packed != row.size) return torn_zip(path, shown);
    out.data = std::string(packed);
  } else {
    out.data.resize(row.size);
    if (!inflate_whole(packed, out.data)) return torn_zip(path, shown);
  }
  if (crc32_z(0, reinterpret_cast<const Bytef*>(out.data.data()), out.data.size()) != row.checksum) {
    return torn_zip(path, shown);
  }
  return out;
}

}  // namespace

bool is_zip(std::string_view bytes) { return bytes.starts_with(kMemberMark); }

Result<std::vector<ZipMember>> read_zip(std::string_view bytes, const std::string& path, std::size_t most_bytes,
                                        std::size_t most_members) {
  const std::size_t tail = bytes.size() > kMostComment + kEndHead ? bytes.size() - kMostComment - kEndHead : 0;
  const std::size_t end = bytes.rfind(kEndMark);
  if (end == std::string_view::npos || end < tail || bytes.size() - end < kEndHead) {
    return torn_zip(path, "no directory at its end");
  }
  const std::size_t count = little_endian(bytes, end + 10, 2);
  std::size_t at = little_endian(bytes, end + 16, 4);
  std::vector<ZipMember> out;
  for (std::size_t i = 0; i < count && out.size() < most_members; ++i) {
    ZipRow row;
    if (!read_row(bytes, at, row)) return torn_zip(path, "directory");
    if (row.size > most_bytes) continue;
    Result<ZipMember> member = read_member(bytes, row, path);
    if (!member) return member.error();
    out.push_back(std::move(*member));
  }
  return out;
}

}  // namespace cliquevo::drivers
