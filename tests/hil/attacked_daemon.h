// SPDX-License-Identifier: BSD-3-Clause
// A daemon that drives a small course for ever, watched through its control socket while it is attacked. No subscriber:
// LCM's own receiver does not survive what is sent here.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/support/subprocess.h"

namespace cliquevo::test {

class AttackedDaemon {
 public:
  // more: further lines of the configuration. Waits until poses flow; without a status until then, ok() is false.
  explicit AttackedDaemon(const std::string& more = "", const Environment& environment = {});
  AttackedDaemon(const AttackedDaemon&) = delete;
  AttackedDaemon& operator=(const AttackedDaemon&) = delete;

  bool ok() const { return ok_; }
  const std::string& folder() const { return folder_; }
  const std::string& socket() const { return socket_; }
  Subprocess& process() { return *process_; }
  // The configuration's file, written anew.
  void configure(const std::string& more) const;
  Finished ctl(const std::string& request) const;
  // Empty object: no answer.
  nlohmann::json status() const;
  // Until done(status) or for so long; the last status.
  nlohmann::json status_once(const std::function<bool(const nlohmann::json&)>& done, double patience_s = 20.0) const;

  // Poses have gone out since, and memory has grown by less than 20 MB since the start.
  void expect_unharmed();
  // SIGTERM: it must end by itself, with 0, within two seconds. What it logged.
  std::string finish();

 private:
  std::string folder_;
  std::string socket_;
  std::unique_ptr<Subprocess> process_;
  bool ok_ = false;
  double bytes_ = 0.0;
};

// One UDP datagram.
bool send_datagram(const std::string& address, int port, const std::string& bytes);
// An LCM message in one datagram, an LCM fragment, and a command_t whose argument claims to have `length` bytes.
std::string short_message(const std::string& channel, const std::string& payload);
std::string fragment(std::uint32_t message_size, std::uint32_t offset, std::uint16_t number, std::uint16_t count,
                     const std::string& payload);
std::string command_payload(int command, std::int32_t length, const std::string& argument = std::string(1, '\0'));

}  // namespace cliquevo::test
