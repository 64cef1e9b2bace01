// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/lcm/lcm_url.h"

#include <gtest/gtest.h>

#include "tests/support/test_data.h"

namespace cliquevo::daemon {
namespace {

TEST(LcmUrl, AUrlThatCannotWorkIsNamedInOneLineWithARemedy) {
  for (const char* url :
       {"", "garbage", "://x", "foo://x", "udpm://", "udpm://239.255.76.67", "udpm://239.255.76.67:0",
        "udpm://239.255.76.67:99999", "udpm://239.255.76.67:76x7", "udpm://127.0.0.1:7667",
        "udpm://no.such.address:7667", "udpm://239.255.76.67:7667?ttl=x", "udpm://239.255.76.67:7667?ttl=300",
        "udpm://239.255.76.67:7667?ttl", "udpm://239.255.76.67:7667?tll=0", "tcpq://127.0.0.1:1", "file://",
        "file:///tmp/x", "file:///tmp/x?mode=r"}) {
    const auto result = check_lcm_url(url);
    ASSERT_FALSE(result.ok()) << url;
    const std::string line = result.error().line();
    EXPECT_EQ(line.find('\n'), std::string::npos) << line;
    EXPECT_NE(line.find(*url == '\0' ? "(empty)" : url), std::string::npos) << line;
    EXPECT_FALSE(result.error().remedy.empty());
  }
}

TEST(LcmUrl, LogsAndTheInProcessQueueNeedNoNetwork) {
  EXPECT_TRUE(check_lcm_url("file://" + test::scratch_dir() + "/x.log?mode=w").ok());
  EXPECT_TRUE(check_lcm_url("memq://").ok());
}

}  // namespace
}  // namespace cliquevo::daemon
