// SPDX-License-Identifier: BSD-3-Clause
// Commands to the running daemon: through its control socket, or by VO_COMMAND.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "core/base/result.h"

namespace cliquevo::daemon {

enum class Command { reset_pose, start_recording, stop_recording };

// Executes it and returns a sentence on what was done. Any thread.
using CommandHandler = std::function<Result<std::string>(Command)>;

// "reset", "record-start", "record-stop".
std::optional<Command> command_of_word(std::string_view word);
// A command_t's constant.
std::optional<Command> command_of_number(std::int8_t number);

enum class Packet { foreign, damaged, command };

// A datagram off the wire, whoever sent it. foreign: of another channel or no whole LCM message (large ones come in
// parts); damaged: on this channel but not a command_t; command: `number` is the command's, known or not.
Packet parse_command_packet(std::span<const std::uint8_t> datagram, std::string_view channel, std::int8_t& number);

}  // namespace cliquevo::daemon
