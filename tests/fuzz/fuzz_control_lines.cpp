// SPDX-License-Identifier: BSD-3-Clause
// A peer of the control socket: its bytes in pieces (the first byte gives their size), each request answered by a line.
#include <algorithm>

#include "daemon/control/control_session.h"
#include "tests/fuzz/expect.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cliquevo;
  if (size == 0) return 0;
  const daemon::ControlHandlers handlers{[](daemon::Command command) -> Result<std::string> {
                                           if (command == daemon::Command::reset_pose) return std::string("done\n\x1b");
                                           return Error{"cannot", "here\n", "do\x9b"};
                                         },
                                         [] { return std::string("{}"); }};
  daemon::ControlSession session(handlers);
  const std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  const std::size_t piece = 1 + data[0] % 100;
  std::string out;
  bool stays = true;
  for (std::size_t at = 0; at < bytes.size() && stays; at += piece) {
    stays = session.take(std::string_view(bytes).substr(at, piece), out);
  }
  const auto requests = std::count(bytes.begin(), bytes.end(), '\n');
  const auto replies = std::count(out.begin(), out.end(), '\n');
  fuzz::expect(stays ? replies == requests : replies <= requests + 1, "a line for each request");
  fuzz::expect(out.empty() || out.back() == '\n', "whole lines");
  for (std::size_t at = 0; at < out.size(); at = out.find('\n', at) + 1) {
    fuzz::expect(out.compare(at, 3, "ok ") == 0 || out.compare(at, 6, "error ") == 0, "ok or error");
  }
  for (const char c : out) fuzz::expect(c == '\n' || static_cast<unsigned char>(c) >= 0x20, "replies are plain text");
  return 0;
}
