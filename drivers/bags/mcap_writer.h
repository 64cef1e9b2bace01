// SPDX-License-Identifier: BSD-3-Clause
// MCAP files of ROS 2 messages: chunks with zstd, each with its index, whole or not there; so a file whose writer died
// is read up to its last chunk.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/base/result.h"
#include "core/base/time.h"

namespace cliquevo::drivers {

class McapWriter {
 public:
  // The file must not be there yet; others than owner and group cannot read it.
  static Result<McapWriter> create(const std::string& path);
  McapWriter(McapWriter&&) noexcept;
  McapWriter& operator=(McapWriter&&) noexcept;
  // Without close() the file lacks its summary, and what its last chunk would have held.
  ~McapWriter();

  // Number of the channel; type "sensor_msgs/msg/Image" with its definition in the form of ros2msg.
  std::uint16_t add_channel(const std::string& topic, const std::string& type, const std::string& definition,
                            bool latched = false);
  // A message in CDR. A chunk goes to the file when it is large, or holds a second of the messages' own time. An error
  // (disk full) leaves the file at its last whole chunk; later calls fail too.
  Result<void> write(std::uint16_t channel, TimestampNs stamp_ns, std::span<const std::uint8_t> cdr);
  // The last chunk and the summary.
  Result<void> close();
  std::int64_t bytes() const;
  std::int64_t messages() const;

 private:
  struct Impl;
  explicit McapWriter(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace cliquevo::drivers
