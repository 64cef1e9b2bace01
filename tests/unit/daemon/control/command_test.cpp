// SPDX-License-Identifier: BSD-3-Clause
// Commands from peers who may send anything.
#include "daemon/control/command.h"

#include <cliquevo/command_t.hpp>
#include <gtest/gtest.h>

#include "daemon/control/control_session.h"
#include "daemon/control/incidents.h"

namespace cliquevo::daemon {
namespace {

std::vector<std::uint8_t> message_of(const command_t& command, const std::string& channel = "VO_COMMAND") {
  std::string out("LC02\0\0\0\x09", 8);
  out.append(channel).push_back('\0');
  std::vector<std::uint8_t> payload(static_cast<std::size_t>(command.getEncodedSize()));
  command.encode(payload.data(), 0, command.getEncodedSize());
  out.append(payload.begin(), payload.end());
  return {out.begin(), out.end()};
}

Packet parse(const std::vector<std::uint8_t>& bytes, std::int8_t& number) {
  // Of exactly that size on the heap: a sanitizer sees a byte read beyond.
  const std::vector<std::uint8_t> exact(bytes.begin(), bytes.end());
  return parse_command_packet({exact.data(), exact.size()}, "VO_COMMAND", number);
}

TEST(CommandPacket, WhatLcmSendsIsUnderstood) {
  command_t command{};
  command.utime = 7;
  std::int8_t number = 0;
  for (const std::string& argument : {std::string(), std::string("of no use")}) {
    for (const std::int8_t what : {command_t::RESET_POSE, command_t::STOP_RECORDING, std::int8_t{99}}) {
      command.command = what;
      command.argument = argument;
      ASSERT_EQ(parse(message_of(command), number), Packet::command);
      EXPECT_EQ(number, what);
    }
  }
  EXPECT_FALSE(command_of_number(99));
  EXPECT_EQ(command_of_number(command_t::START_RECORDING), Command::start_recording);
}

TEST(CommandPacket, CutLongerOrWithAnyLengthOfTextItIsLeftAlone) {
  command_t command{};
  command.command = command_t::RESET_POSE;
  const std::vector<std::uint8_t> whole = message_of(command);
  std::int8_t number = 0;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_NE(parse({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)}, number), Packet::command);
  }
  std::vector<std::uint8_t> longer = whole;
  longer.push_back(0);
  EXPECT_EQ(parse(longer, number), Packet::damaged);
  for (const std::uint32_t length : {0U, 2U, 0xffffffffU, 0x80000000U, 0x7fffffffU}) {
    std::vector<std::uint8_t> torn = whole;
    for (std::size_t i = 0; i < 4; ++i) torn[torn.size() - 5 + i] = static_cast<std::uint8_t>(length >> (24 - 8 * i));
    EXPECT_EQ(parse(torn, number), Packet::damaged) << length;
  }
  EXPECT_EQ(parse(message_of(command, "VO_COMMANDS"), number), Packet::foreign);
  EXPECT_EQ(parse(message_of(command, "POSE_BODY"), number), Packet::foreign);
  std::vector<std::uint8_t> part = whole;
  part[3] = '3';  // of a message in several datagrams
  EXPECT_EQ(parse(part, number), Packet::foreign);
}

ControlHandlers handlers_noting(std::vector<Command>& done) {
  return {[&done](Command command) -> Result<std::string> {
            if (command == Command::start_recording) return Error{"cannot record", "here", "make\nroom\x1b"};
            done.push_back(command);
            return std::string("done");
          },
          [] { return std::string(R"({"state":"running"})"); }};
}

TEST(ControlSession, AnswersEachLineWithALine) {
  std::vector<Command> done;
  const ControlHandlers handlers = handlers_noting(done);
  ControlSession session(handlers);
  std::string out;
  EXPECT_TRUE(session.take("re", out));
  EXPECT_EQ(out, "");
  EXPECT_TRUE(session.take("set\nrecord-start\r\nstatus\nnonsense\n\n", out));
  EXPECT_EQ(out.substr(0, out.find("error no request")),
            "ok done\nerror cannot record: here: make room?\nok {\"state\":\"running\"}\n");
  EXPECT_EQ(std::count(out.begin(), out.end(), '\n'), 5);
  EXPECT_EQ(done, std::vector<Command>{Command::reset_pose});
}

TEST(ControlSession, HangsUpOnALineWithoutEnd) {
  std::vector<Command> done;
  const ControlHandlers handlers = handlers_noting(done);
  ControlSession session(handlers);
  std::string out;
  EXPECT_TRUE(session.take(std::string(64, 'x'), out));
  EXPECT_FALSE(session.take("x", out));
  EXPECT_EQ(out.rfind("error ", 0), 0U);
}

TEST(ControlSession, AHandlerThatThrowsIsAnError) {
  const ControlHandlers handlers{[](Command) -> Result<std::string> { throw std::bad_alloc(); },
                                 []() -> std::string { throw std::bad_alloc(); }};
  ControlSession session(handlers);
  std::string out;
  EXPECT_TRUE(session.take("reset\nstatus\n", out));
  EXPECT_EQ(out.rfind("error cannot go on: ", 0), 0U) << out;
}

TEST(Incidents, AreCountedAndToldAndNeverMoreThanAFew) {
  Incidents incidents;
  EXPECT_EQ(incidents.text(), "");
  incidents.log("somebody reset the pose");
  EXPECT_EQ(incidents.text(), "") << "no fault";
  for (int i = 0; i < 1000; ++i) incidents.add("damaged packets");
  EXPECT_EQ(incidents.text(), "damaged packets (1000 times since the start)");
  for (int i = 0; i < 40; ++i) incidents.add("another kind " + std::to_string(i));
  EXPECT_LT(incidents.text().size(), 1500U);
}

}  // namespace
}  // namespace cliquevo::daemon
