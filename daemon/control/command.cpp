// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/control/command.h"

#include <cstring>

#include <cliquevo/command_t.hpp>

namespace cliquevo::daemon {

namespace {

constexpr std::uint64_t kShortMessage = 0x4c433032;  // "LC02": a message in one datagram

// A number of `bytes` bytes off the front, the highest first; nothing: not so many left.
std::optional<std::uint64_t> take(std::span<const std::uint8_t>& data, std::size_t bytes) {
  if (data.size() < bytes) return std::nullopt;
  std::uint64_t value = 0;
  for (const std::uint8_t byte : data.first(bytes)) value = value << 8U | byte;
  data = data.subspan(bytes);
  return value;
}

}  // namespace

std::optional<Command> command_of_word(std::string_view word) {
  if (word == "reset") return Command::reset_pose;
  if (word == "record-start") return Command::start_recording;
  if (word == "record-stop") return Command::stop_recording;
  return std::nullopt;
}

std::optional<Command> command_of_number(std::int8_t number) {
  if (number == command_t::RESET_POSE) return Command::reset_pose;
  if (number == command_t::START_RECORDING) return Command::start_recording;
  if (number == command_t::STOP_RECORDING) return Command::stop_recording;
  return std::nullopt;
}

// magic (4), number of the message (4), channel, 0, and command_t: hash (8), utime (8), command (1), length of the
// argument with its 0 (4), argument, 0.
Packet parse_command_packet(std::span<const std::uint8_t> data, std::string_view channel, std::int8_t& number) {
  if (take(data, 4) != kShortMessage || !take(data, 4)) return Packet::foreign;
  if (data.size() <= channel.size() || std::memcmp(data.data(), channel.data(), channel.size()) != 0 ||
      data[channel.size()] != 0) {
    return Packet::foreign;
  }
  data = data.subspan(channel.size() + 1);
  if (take(data, 8) != static_cast<std::uint64_t>(command_t::getHash()) || !take(data, 8)) return Packet::damaged;
  const auto command = take(data, 1);
  const auto length = take(data, 4);
  if (!command || !length || *length == 0 || *length != data.size() || data.back() != 0) return Packet::damaged;
  number = static_cast<std::int8_t>(*command);
  return Packet::command;
}

}  // namespace cliquevo::daemon
