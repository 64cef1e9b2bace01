// SPDX-License-Identifier: BSD-3-Clause
// What may reach a GigE Vision stream's socket. Aravis takes a frame's number of packets from whatever datagram comes
// first, also from a forged one: it requests 58 GB, or copies beyond its buffers. The kernel drops such datagrams
// before Aravis sees them, by a socket filter that is made from the camera's own geometry.
#pragma once

#include <cstddef>
#include <cstdint>
#include <linux/filter.h>
#include <vector>

#include "core/base/result.h"

namespace cliquevo::drivers {

struct StreamShape {
  std::uint32_t camera_address = 0;  // IPv4, host byte order
  std::size_t payload_bytes = 0;     // of a frame
  std::size_t packet_bytes = 0;      // of a datagram with its IP and UDP headers, as the camera was set
  std::uint32_t width = 0;           // of the image [px]
  std::uint32_t height = 0;
};

// Lets through: leaders of single images of this size, payload and trailer packets whose number such a frame has, each
// whole and from the camera's address. All else is dropped.
std::vector<sock_filter> stream_filter(const StreamShape& shape);

// Attaches it to this process's UDP socket of that port and waits until what came before has been read.
Result<void> guard_stream(std::uint16_t port, const std::vector<sock_filter>& filter);

}  // namespace cliquevo::drivers
