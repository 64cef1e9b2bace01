// SPDX-License-Identifier: BSD-3-Clause
// Each way in which cameras pack samples of 10 and 12 bits, packed here by its definition and taken apart again.
#include "drivers/images/packed_samples.h"

#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace cliquevo::drivers {
namespace {

using Bytes = std::vector<std::uint8_t>;
using Samples = std::vector<unsigned>;

// Bit after bit, lowest or highest first.
Bytes run_on(const Samples& samples, unsigned bits, bool lowest_first) {
  std::vector<bool> all;
  for (const unsigned s : samples) {
    for (unsigned k = 0; k < bits; ++k) all.push_back((s >> (lowest_first ? k : bits - 1 - k) & 1U) != 0);
  }
  Bytes out((all.size() + 7) / 8, 0);
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (all[i]) out[i / 8] = static_cast<std::uint8_t>(out[i / 8] | 1U << (lowest_first ? i % 8 : 7 - i % 8));
  }
  return out;
}

Bytes packed(PackedSamples kind, const Samples& s) {
  Bytes out;
  const auto put = [&out](unsigned value) { out.push_back(static_cast<std::uint8_t>(value & 255U)); };
  switch (kind) {
    case PackedSamples::mipi_10:
      for (std::size_t i = 0; i < s.size(); i += 4) {
        for (std::size_t k = 0; k < 4; ++k) put(s[i + k] >> 2U);
        put((s[i] & 3U) | (s[i + 1] & 3U) << 2U | (s[i + 2] & 3U) << 4U | (s[i + 3] & 3U) << 6U);
      }
      return out;
    case PackedSamples::mipi_12:
      for (std::size_t i = 0; i < s.size(); i += 2)
        put(s[i] >> 4U), put(s[i + 1] >> 4U), put((s[i] & 15U) | (s[i + 1] & 15U) << 4U);
      return out;
    case PackedSamples::gige_10_or_12:
      for (std::size_t i = 0; i < s.size(); i += 2)
        put(s[i] >> 4U), put((s[i] & 15U) | (s[i + 1] & 15U) << 4U), put(s[i + 1] >> 4U);
      return out;
    case PackedSamples::big_endian_10:
      return run_on(s, 10, false);
    case PackedSamples::pfnc_10:
      return run_on(s, 10, true);
    case PackedSamples::pfnc_12:
      return run_on(s, 12, true);
  }
  return out;
}

constexpr PackedSamples kKinds[] = {PackedSamples::mipi_10,       PackedSamples::mipi_12, PackedSamples::big_endian_10,
                                    PackedSamples::gige_10_or_12, PackedSamples::pfnc_10, PackedSamples::pfnc_12};

unsigned bits_of(PackedSamples kind) {
  const bool ten =
      kind == PackedSamples::mipi_10 || kind == PackedSamples::big_endian_10 || kind == PackedSamples::pfnc_10;
  return ten ? 10 : 12;
}

TEST(PackedSamples, TheUpperEightBitsComeOutOfEveryPacking) {
  for (const PackedSamples kind : kKinds) {
    Samples samples;
    for (unsigned i = 0; i < 32; ++i) samples.push_back((i * 397U + 11U) & ((1U << bits_of(kind)) - 1U));
    const Bytes data = packed(kind, samples);
    Image<std::uint8_t> out(8, 4);
    ASSERT_TRUE(unpack_samples(kind, data.data(), data.size(), 0, out.view())) << static_cast<int>(kind);
    for (int i = 0; i < 32; ++i) {
      EXPECT_EQ(out.view()(i % 8, i / 8), samples[static_cast<std::size_t>(i)] >> (bits_of(kind) - 8))
          << static_cast<int>(kind) << ' ' << i;
    }
  }
}

TEST(PackedSamples, RowsMayStandApart) {
  const Samples row{1023, 512, 4, 0};
  Bytes data = packed(PackedSamples::mipi_10, row);
  data.resize(9, 0xEE);
  const Bytes second = packed(PackedSamples::mipi_10, {0, 4, 512, 1023});
  data.insert(data.end(), second.begin(), second.end());
  Image<std::uint8_t> out(4, 2);
  ASSERT_TRUE(unpack_samples(PackedSamples::mipi_10, data.data(), data.size(), 9, out.view()));
  EXPECT_EQ(out.view()(0, 0), 255);
  EXPECT_EQ(out.view()(0, 1), 0);
  EXPECT_EQ(out.view()(3, 1), 255);
}

TEST(PackedSamples, TooLittleDataIsRefused) {
  for (const PackedSamples kind : kKinds) {
    const Bytes data = packed(kind, Samples(32, 700));
    Image<std::uint8_t> out(8, 4);
    EXPECT_FALSE(unpack_samples(kind, data.data(), data.size() - 1, 0, out.view()));
    EXPECT_FALSE(unpack_samples(kind, data.data(), data.size(), 8, out.view())) << "rows that overlap";
  }
}

}  // namespace
}  // namespace cliquevo::drivers
