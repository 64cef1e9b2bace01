// SPDX-License-Identifier: BSD-3-Clause
// Which IPv4 addresses are this machine's own. The kernel takes no packet from outside that bears one of them as its
// source.
#pragma once

#include <cstdint>
#include <netinet/in.h>
#include <vector>

namespace cliquevo::daemon {

class LocalAddresses {
 public:
  // Queries the system when it does not know the address, once a second at most.
  bool contains(in_addr address);

 private:
  std::vector<in_addr_t> known_;
  std::int64_t asked_ns_ = 0;
};

}  // namespace cliquevo::daemon
