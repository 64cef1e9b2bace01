// SPDX-License-Identifier: BSD-3-Clause
// A datagram on the command channel. Of exactly its size on the heap: a byte read beyond is seen.
#include <memory>
#include <vector>

#include <cliquevo/command_t.hpp>

#include "daemon/control/command.h"
#include "tests/fuzz/expect.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cliquevo;
  std::int8_t number = 0;
  if (daemon::parse_command_packet({data, size}, "VO_COMMAND", number) != daemon::Packet::command) return 0;
  daemon::command_of_number(number);
  // What is taken is what LCM's own decoder reads.
  const std::size_t head = 8 + std::string("VO_COMMAND").size() + 1;
  command_t command{};
  const int used = command.decode(data + head, 0, static_cast<int>(size - head));
  fuzz::expect(used == static_cast<int>(size - head), "a whole command_t");
  fuzz::expect(command.command == number, "the number that was sent");
  return 0;
}
