// SPDX-License-Identifier: BSD-3-Clause
// Where MAVLink goes: UDP or a serial line. Nothing here waits: what does not fit is left out.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/base/result.h"

namespace cliquevo::tools {

class MavlinkLink {
 public:
  // udp:HOST:PORT, serial:DEVICE[:BAUD] (default 921600). An error names what is wrong with `to`.
  static Result<MavlinkLink> open(const std::string& to);
  MavlinkLink(MavlinkLink&& other) noexcept;
  MavlinkLink& operator=(MavlinkLink&& other) noexcept;
  ~MavlinkLink();

  int descriptor() const { return descriptor_; }
  // One frame, whole or not at all; false: left out. An error: the line is gone.
  Result<bool> send(std::span<const std::uint8_t> frame);
  // What has come in, if anything.
  Result<std::span<const std::uint8_t>> receive();
  // Goes on with what a serial line has not taken yet.
  Result<void> flush();
  bool has_pending() const { return !pending_.empty(); }

 private:
  MavlinkLink(int descriptor, bool serial, std::string name)
      : descriptor_(descriptor), serial_(serial), name_(std::move(name)) {}
  Error gone(int code) const;

  int descriptor_ = -1;
  bool serial_ = false;
  std::string name_;
  std::vector<std::uint8_t> pending_;  // of frames that the serial line has begun with
  std::vector<std::uint8_t> received_;
};

}  // namespace cliquevo::tools
