// SPDX-License-Identifier: BSD-3-Clause
// Records of an MCAP file, as reader and writer know them (https://mcap.dev/spec).
#pragma once

#include <cstdint>

namespace cliquevo::drivers::mcap {

enum Op : std::uint8_t {
  kHeader = 0x01,
  kFooter = 0x02,
  kSchema = 0x03,
  kChannel = 0x04,
  kMessage = 0x05,
  kChunk = 0x06,
  kMessageIndex = 0x07,
  kChunkIndex = 0x08,
  kStatistics = 0x0b,
  kSummaryOffset = 0x0e,
  kDataEnd = 0x0f,
};

}  // namespace cliquevo::drivers::mcap
