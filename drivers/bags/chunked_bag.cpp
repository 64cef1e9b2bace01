// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/bags/chunked_bag.h"

#include <algorithm>

#include <fmt/format.h>

namespace cliquevo::drivers {

namespace {

constexpr std::uint64_t kLargestMessage = std::uint64_t{1} << 30U;

}  // namespace

Result<void> ChunkedBag::read(const BagMessage& message, std::vector<std::uint8_t>& out, std::size_t most) {
  const auto damaged = [&](const char* what) {
    return Error{"cannot read message", path_ + ", " + topics_[message.topic].name, what};
  };
  if (most == SIZE_MAX && !store_.is_intact(message.chunk)) {
    return damaged("its chunk's checksum is wrong: copy the bag again");
  }
  const std::optional<Place> place = place_of(message.chunk, message.at);
  if (!place || place->size > kLargestMessage) return damaged("the bag is damaged there: copy it again");
  out.resize(static_cast<std::size_t>(std::min<std::uint64_t>(place->size, most)));
  if (!store_.read(message.chunk, place->at, out.data(), out.size())) {
    return damaged("the bag is damaged there: copy it again");
  }
  return {};
}

bool ChunkedBag::add_message(std::uint32_t channel, TimestampNs received_ns, std::uint64_t at, std::int32_t chunk) {
  if (messages_.size() >= kMostBagMessages) return false;
  messages_.push_back({received_ns, at, channel, chunk});
  used_channels_.insert(channel);
  return true;
}

bool ChunkedBag::misses_channels() {
  std::erase_if(used_channels_, [this](std::uint32_t id) { return knows_channel(id); });
  return !used_channels_.empty();
}

Result<void> ChunkedBag::settle() {
  std::size_t kept = 0;
  for (const BagMessage& message : messages_) {
    const auto topic = channels_.find(message.topic);
    if (topic == channels_.end()) continue;
    messages_[kept] = message;
    messages_[kept++].topic = topic->second;
  }
  if (kept < messages_.size()) note_damage(fmt::format("{} messages of unknown channels", messages_.size() - kept));
  messages_.resize(kept);
  if (messages_.empty()) return Error{"bag has no message", path_, "copy it again, or record one"};
  return {};
}

void ChunkedBag::note_damage(const std::string& what) {
  if (!damage_.empty()) damage_ += "; ";
  damage_ += what;
}

}  // namespace cliquevo::drivers
