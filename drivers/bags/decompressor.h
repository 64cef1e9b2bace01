// SPDX-License-Identifier: BSD-3-Clause
// Compressed blocks of a bag, decompressed only as far as they are needed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace cliquevo::drivers {

enum class Compression { none, zstd, lz4, bz2 };

// By its name in a container; nothing for one that is not known.
std::optional<Compression> compression_named(std::string_view name);

// A stream: bytes in, bytes out.
class Decompressor {
 public:
  virtual ~Decompressor() = default;
  struct Step {
    std::size_t taken = 0;  // of `in`
    std::size_t given = 0;  // into `out`
    bool ended = false;     // the stream's own end
    bool broken = false;
  };
  virtual Step step(std::span<const std::uint8_t> in, std::span<std::uint8_t> out) = 0;
};
// For anything but Compression::none. Null where the library has no memory for it.
std::unique_ptr<Decompressor> make_decompressor(Compression kind);

// The first `most` bytes of a whole block in memory; false: damaged or cut off before that.
bool decompress_block(Compression kind, std::span<const std::uint8_t> in, std::size_t most,
                      std::vector<std::uint8_t>& out);

}  // namespace cliquevo::drivers
