// SPDX-License-Identifier: BSD-3-Clause
// A network of the test's own: multicast works on it and nobody else's messages are there.
#pragma once

#include <sched.h>

#include <gtest/gtest.h>

namespace cliquevo::test {

// Moves this process, and with it every program that it starts, into a new network namespace. Before any thread is
// started. false: not allowed to.
inline bool enter_private_network() {
  return ::unshare(CLONE_NEWNET) == 0 &&
         std::system("ip link set lo up && ip link set lo multicast on && ip route add 224.0.0.0/4 dev lo") == 0;
}

}  // namespace cliquevo::test

#define CLIQUEVO_NEEDS_PRIVATE_NETWORK() \
  if (!::cliquevo::test::enter_private_network()) GTEST_SKIP() << "needs root and iproute2 for a network namespace"
