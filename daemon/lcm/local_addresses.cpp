// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/lcm/local_addresses.h"

#include <algorithm>
#include <cstring>
#include <ifaddrs.h>
#include <memory>
#include <sys/socket.h>

#include "core/base/time.h"

namespace cliquevo::daemon {

namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;

std::vector<in_addr_t> query() {
  std::vector<in_addr_t> out;
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) != 0) return out;
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> owner(list, &::freeifaddrs);
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    if (entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != AF_INET) continue;
    sockaddr_in address{};
    std::memcpy(&address, entry->ifa_addr, sizeof address);
    out.push_back(address.sin_addr.s_addr);
  }
  return out;
}

}  // namespace

bool LocalAddresses::contains(in_addr address) {
  if (ntohl(address.s_addr) >> 24U == IN_LOOPBACKNET) return true;
  const auto known = [&] { return std::find(known_.begin(), known_.end(), address.s_addr) != known_.end(); };
  if (known()) return true;
  const std::int64_t now_ns = monotonic_ns();
  if (asked_ns_ != 0 && now_ns - asked_ns_ < kSecondNs) return false;
  asked_ns_ = now_ns;
  known_ = query();
  return known();
}

}  // namespace cliquevo::daemon
