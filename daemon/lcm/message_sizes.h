// SPDX-License-Identifier: BSD-3-Clause
// Whether a message's counts fit its size. LCM's decoders make room for what a count says before they look whether it
// can be: a few damaged bytes would take gigabytes.
#pragma once

#include <cstddef>
#include <cstdint>

#include <cliquevo/command_t.hpp>
#include <cliquevo/features_t.hpp>
#include <cliquevo/health_t.hpp>
#include <cliquevo/images_t.hpp>
#include <cliquevo/movers_t.hpp>
#include <cliquevo/points_t.hpp>
#include <cliquevo/status_t.hpp>

namespace cliquevo::daemon {

inline constexpr std::size_t kMostMessageBytes = std::size_t{1} << 30U;

struct MessageBytes {
  const std::uint8_t* data = nullptr;
  std::size_t size = 0;
};

// The message that is handed over gives the type alone. Types without counts always fit.
template <typename Message>
bool fits(const MessageBytes&, const Message&) {
  return true;
}
template <>
bool fits(const MessageBytes& bytes, const command_t&);
template <>
bool fits(const MessageBytes& bytes, const features_t&);
template <>
bool fits(const MessageBytes& bytes, const health_t&);
template <>
bool fits(const MessageBytes& bytes, const images_t&);
template <>
bool fits(const MessageBytes& bytes, const movers_t&);
template <>
bool fits(const MessageBytes& bytes, const points_t&);
template <>
bool fits(const MessageBytes& bytes, const status_t&);

// Decodes what may come from anywhere; false where it is no whole message of that type.
template <typename Message>
bool decode_checked(const void* data, std::size_t size, Message& out) {
  if (size > kMostMessageBytes || !fits({static_cast<const std::uint8_t*>(data), size}, out)) return false;
  const int bytes = static_cast<int>(size);
  return out.decode(data, 0, bytes) == bytes;
}

}  // namespace cliquevo::daemon
