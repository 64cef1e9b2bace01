// SPDX-License-Identifier: BSD-3-Clause
// What .mcap and .bag have in common: messages in chunks, by number and offset.
#pragma once

#include <optional>
#include <string>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <vector>

#include "drivers/bags/bag.h"
#include "drivers/bags/chunk_store.h"

namespace cliquevo::drivers {

class ChunkedBag : public Bag {
 public:
  Result<void> read(const BagMessage& message, std::vector<std::uint8_t>& out, std::size_t most) override;

 protected:
  ChunkedBag(std::string path, FileBytes file) : store_(std::move(file)) { path_ = std::move(path); }

  // Where a message's own bytes are, of the record at an offset; nothing where there is no message.
  struct Place {
    std::uint64_t at = 0;
    std::uint64_t size = 0;
  };
  virtual std::optional<Place> place_of(std::int32_t chunk, std::uint64_t at) = 0;

  // Channels (of MCAP) and connections (of ROS 1) by the container's numbers.
  void define_channel(std::uint32_t id, BagTopic topic) { channels_[id] = topic_number(std::move(topic)); }
  bool knows_channel(std::uint32_t id) const { return channels_.count(id) > 0; }
  // Whether a message is of a channel that is not defined (yet).
  bool misses_channels();
  // false: more messages than any bag holds.
  bool add_message(std::uint32_t channel, TimestampNs received_ns, std::uint64_t at, std::int32_t chunk);
  // From the containers' numbers to those of topics; messages of unknown channels are left out, and said.
  Result<void> settle();
  void note_damage(const std::string& what);

  ChunkStore store_;

 private:
  std::unordered_map<std::uint32_t, std::uint32_t> channels_;
  std::unordered_set<std::uint32_t> used_channels_;
};

}  // namespace cliquevo::drivers
