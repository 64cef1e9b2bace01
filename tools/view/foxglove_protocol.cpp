// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view/foxglove_protocol.h"

#include <algorithm>
#include <limits>

#include <nlohmann/json.hpp>

#include "drivers/bags/ros2_definitions.h"

namespace cliquevo::view {

namespace {

using nlohmann::json;

std::optional<std::uint32_t> number(const json& value) {
  if (!value.is_number_unsigned()) return std::nullopt;
  const auto out = value.get<std::uint64_t>();
  if (out > std::numeric_limits<std::uint32_t>::max()) return std::nullopt;
  return static_cast<std::uint32_t>(out);
}

std::optional<FoxgloveSubscription> subscription(const json& value) {
  if (!value.is_object()) return std::nullopt;
  const auto id = value.find("id");
  const auto channel = value.find("channelId");
  if (id == value.end() || channel == value.end()) return std::nullopt;
  const auto id_number = number(*id);
  const auto channel_number = number(*channel);
  if (!id_number || !channel_number) return std::nullopt;
  return FoxgloveSubscription{*id_number, *channel_number};
}

// Every entry of message[key] by `read`; false: there is no such list, or an entry is none.
template <typename Entry, typename Read>
bool read_list(const json& message, const char* key, Read read, std::vector<Entry>& out) {
  const auto list = message.find(key);
  if (list == message.end() || !list->is_array()) return false;
  for (const json& value : *list) {
    const auto entry = read(value);
    if (!entry) return false;
    out.push_back(*entry);
  }
  return true;
}

}  // namespace

bool offers_foxglove(std::string_view protocols) {
  while (!protocols.empty()) {
    const std::size_t end = std::min(protocols.find(','), protocols.size());
    std::string_view one = protocols.substr(0, end);
    while (!one.empty() && one.front() == ' ') one.remove_prefix(1);
    while (!one.empty() && one.back() == ' ') one.remove_suffix(1);
    if (one == kFoxgloveProtocol) return true;
    protocols.remove_prefix(std::min(end + 1, protocols.size()));
  }
  return false;
}

std::optional<FoxgloveRequest> parse_foxglove_request(std::string_view text) {
  if (text.size() > kMostFoxgloveBytes) return std::nullopt;
  const json message = json::parse(text, nullptr, false);
  if (!message.is_object()) return std::nullopt;
  const auto op = message.find("op");
  if (op == message.end() || !op->is_string()) return std::nullopt;
  FoxgloveRequest out;
  if (*op == "subscribe" && !read_list(message, "subscriptions", subscription, out.subscribe)) return std::nullopt;
  if (*op == "unsubscribe" && !read_list(message, "subscriptionIds", number, out.unsubscribe)) return std::nullopt;
  return out;
}

std::string foxglove_server_info(std::string_view version, std::string_view session) {
  return json{{"op", "serverInfo"},
              {"name", "cliquevo " + std::string(version)},
              {"capabilities", json::array()},
              {"supportedEncodings", json::array()},
              {"metadata", json::object()},
              {"sessionId", session}}
      .dump();
}

std::string foxglove_advertisement() {
  json channels = json::array();
  for (std::uint32_t channel = 1; const auto topic = topic_of_channel(channel); ++channel) {
    const TopicInfo& info = topic_info(*topic);
    const std::string package = info.package;
    channels.push_back({{"id", channel},
                        {"topic", info.name},
                        {"encoding", "cdr"},
                        {"schemaName", package + "/msg/" + info.type},
                        {"schema", drivers::ros2_definition(package + "/" + info.type)},
                        {"schemaEncoding", "ros2msg"}});
  }
  return json{{"op", "advertise"}, {"channels", channels}}.dump();
}

std::string foxglove_warning(std::string_view text) {
  return json{{"op", "status"}, {"level", 1}, {"message", text}}.dump();
}

std::array<std::uint8_t, kFoxgloveHeadBytes> foxglove_message_head(std::uint32_t subscription, TimestampNs stamp_ns) {
  constexpr std::uint8_t kMessageData = 1;
  std::array<std::uint8_t, kFoxgloveHeadBytes> out{kMessageData};
  for (std::size_t i = 0; i < 4; ++i) out[1 + i] = static_cast<std::uint8_t>(subscription >> (8 * i));
  const auto stamp = static_cast<std::uint64_t>(std::max<TimestampNs>(0, stamp_ns));
  for (std::size_t i = 0; i < 8; ++i) out[5 + i] = static_cast<std::uint8_t>(stamp >> (8 * i));
  return out;
}

std::optional<Topic> topic_of_channel(std::uint32_t channel) {
  if (channel < 1 || channel > kTopics) return std::nullopt;
  return static_cast<Topic>(channel - 1);
}

}  // namespace cliquevo::view
