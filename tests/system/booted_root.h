// SPDX-License-Identifier: BSD-3-Clause
// A small Debian booted by systemd-nspawn with the package installed: the service as users run it.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <sys/types.h>
#include <vector>

#include "tests/support/subprocess.h"

namespace cliquevo::test {

// Makes or refreshes the root (tests/system/service_root) with the package of this build. Empty: done; else why not.
std::string install_package();

class BootedRoot {
 public:
  // Nothing that is written in the booted root outlives it. Loopback takes multicast, unless without_route.
  static std::unique_ptr<BootedRoot> boot(bool without_route = false);
  ~BootedRoot();
  BootedRoot(const BootedRoot&) = delete;
  BootedRoot& operator=(const BootedRoot&) = delete;

  // A command of the booted system.
  Finished run(const std::vector<std::string>& command) const;
  // A command of this machine, in the booted system's network.
  std::vector<std::string> in_its_network(std::vector<std::string> command) const;
  void write(const std::string& path, const std::string& text) const;

  std::string property(const std::string& name) const;  // of cliquevod.service, as systemctl show prints it
  // Waits until the unit's property has the value. false: not within timeout_s.
  bool wait_for(const std::string& name, const std::string& value, double timeout_s) const;
  // The daemon's process and thread numbers as this machine counts them; nothing when it does not run.
  std::optional<pid_t> daemon() const;
  std::optional<pid_t> thread_of_daemon(const std::string& name) const;

 private:
  BootedRoot() = default;
  std::string enter_;  // process number of its first process
  std::unique_ptr<Subprocess> nspawn_;
};

}  // namespace cliquevo::test
