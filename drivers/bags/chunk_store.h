// SPDX-License-Identifier: BSD-3-Clause
// The chunks of a bag by number and offset within their decompressed content.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "drivers/bags/decompressor.h"
#include "drivers/bags/file_bytes.h"

namespace cliquevo::drivers {

struct Chunk {
  std::uint64_t at = 0;           // of its content in the file
  std::uint64_t stored_size = 0;  // there; less than it claims at a file's torn end
  std::uint64_t size = 0;         // decompressed, as claimed
  Compression compression = Compression::none;
  std::uint32_t crc = 0;  // of the decompressed content; 0 = not given
};

// Decompressed chunks are kept while others are not needed; each only up to what was read of it.
class ChunkStore {
 public:
  explicit ChunkStore(FileBytes file);
  ~ChunkStore();
  ChunkStore(ChunkStore&&) noexcept;
  ChunkStore& operator=(ChunkStore&&) noexcept;

  const FileBytes& file() const { return file_; }
  // Its number.
  std::int32_t add(const Chunk& chunk);
  std::int32_t count() const { return static_cast<std::int32_t>(chunks_.size()); }
  // Bytes of chunk `number`, or of the file (-1). false: not so many there, or they are damaged.
  bool read(std::int32_t number, std::uint64_t at, void* out, std::size_t count);
  // Whether a compressed chunk has the checksum that it claims; one that breaks off has none to compare.
  bool is_intact(std::int32_t number);
  // Size of what read() may reach, as claimed.
  std::uint64_t size(std::int32_t number) const;

 private:
  struct Open;
  Open* open(std::int32_t number);

  FileBytes file_;
  std::vector<Chunk> chunks_;
  std::array<std::unique_ptr<Open>, 2> open_;  // the last used first
};

}  // namespace cliquevo::drivers
