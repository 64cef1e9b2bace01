// SPDX-License-Identifier: BSD-3-Clause
// foxglove.websocket.v1, as far as a server needs it that sends and takes nothing: text in, what is meant out.
// https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/time.h"
#include "tools/view/ros2_topics.h"

namespace cliquevo::view {

inline constexpr std::string_view kFoxgloveProtocol = "foxglove.websocket.v1";
inline constexpr std::size_t kMostFoxgloveBytes = 16384;  // of a client's message
inline constexpr std::size_t kMostSubscriptions = 64;     // of a client

// Whether a list of subprotocols ("a, b") names it.
bool offers_foxglove(std::string_view protocols);

struct FoxgloveSubscription {
  std::uint32_t id = 0;       // the client's
  std::uint32_t channel = 0;  // may be none of ours
};
struct FoxgloveRequest {
  std::vector<FoxgloveSubscription> subscribe;
  std::vector<std::uint32_t> unsubscribe;
};
// None: not a message of the protocol. What is one but of a kind that this server does not offer is empty.
std::optional<FoxgloveRequest> parse_foxglove_request(std::string_view text);

// The first two messages.
std::string foxglove_server_info(std::string_view version, std::string_view session);
std::string foxglove_advertisement();
// Something was wrong with what a client sent.
std::string foxglove_warning(std::string_view text);

// What goes before a message's bytes.
inline constexpr std::size_t kFoxgloveHeadBytes = 13;
std::array<std::uint8_t, kFoxgloveHeadBytes> foxglove_message_head(std::uint32_t subscription, TimestampNs stamp_ns);

// Channels are topics, counted from 1.
std::optional<Topic> topic_of_channel(std::uint32_t channel);

}  // namespace cliquevo::view
