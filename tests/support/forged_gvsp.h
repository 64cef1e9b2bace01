// SPDX-License-Identifier: BSD-3-Clause
// Packets of GigE Vision's stream protocol, as a camera sends them or as nobody should.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace cliquevo::test {

using Bytes = std::vector<std::uint8_t>;

enum class GvspKind : std::uint8_t { leader = 1, trailer = 2, payload = 3, all_in = 4, h264 = 5, multipart = 7 };

inline void put_big_endian(Bytes& to, std::uint64_t value, int bytes) {
  for (int i = bytes - 1; i >= 0; --i)
    to.push_back(i < 8 ? static_cast<std::uint8_t>(value >> (8 * i)) : std::uint8_t{0});
}

// extended: 64-bit frame numbers and 32-bit packet numbers.
inline Bytes gvsp_packet(bool extended, GvspKind kind, std::uint64_t frame, std::uint32_t number, std::size_t body) {
  Bytes out;
  put_big_endian(out, 0, 2);  // status
  put_big_endian(out, extended ? 0 : frame, 2);
  out.push_back(static_cast<std::uint8_t>((extended ? 0x80U : 0U) | static_cast<unsigned>(kind)));
  put_big_endian(out, extended ? 0 : number, 3);
  if (extended) {
    put_big_endian(out, frame, 8);
    put_big_endian(out, number, 4);
  }
  out.resize(out.size() + body, 0x55);
  return out;
}

inline Bytes gvsp_leader(bool extended, std::uint64_t frame, std::uint32_t width, std::uint32_t height,
                         std::uint16_t payload_type = 1) {
  Bytes out = gvsp_packet(extended, GvspKind::leader, frame, 0, 0);
  put_big_endian(out, 0, 2);
  put_big_endian(out, payload_type, 2);
  put_big_endian(out, 0, 8);           // stamp
  put_big_endian(out, 0x01080001, 4);  // Mono8
  put_big_endian(out, width, 4);
  put_big_endian(out, height, 4);
  put_big_endian(out, 0, 12);  // offsets and padding
  return out;
}

}  // namespace cliquevo::test
