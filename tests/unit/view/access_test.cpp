// SPDX-License-Identifier: BSD-3-Clause
#include "tools/view/access.h"

#include <gtest/gtest.h>

#include "tools/view/page_files.h"

namespace cliquevo::view {
namespace {

const AccessRules kLocal{8470, "", {}};
const AccessRules kOpen{8470, "0123456789abcdef0123456789abcdef", {}};

int get(std::string_view host, std::string_view origin = "", std::string_view target = "/",
        const AccessRules& rules = kLocal, std::string_view cookie = "") {
  return judge({"GET", target, host, origin, cookie, target == "/live", ""}, rules).status;
}

TEST(Access, OnlyNumbersAndLocalhostNameUs) {
  for (const char* host : {"127.0.0.1:8470", "localhost:8470", "[::1]:8470", "192.168.1.7:8470"}) {
    EXPECT_EQ(get(host), 200) << host;
  }
  for (const char* host : {"", "evil.example", "evil.example:8470", "127.0.0.1", "127.0.0.1:847", "127.0.0.1:84700",
                           "[::1:8470", "::1:8470", "[]:8470", "127.0.0.1.evil:8470", ":8470", "[evil]:8470"}) {
    EXPECT_EQ(get(host), 421) << host;
  }
}

TEST(Access, AnotherPlacesPageMayNotConnect) {
  EXPECT_EQ(get("127.0.0.1:8470", "http://127.0.0.1:8470", "/live"), 200);
  for (const char* origin : {"http://evil.example", "null", "https://127.0.0.1:8470", "http://127.0.0.1:8471",
                             "http://127.0.0.1:84700", "http://localhost:8470"}) {
    EXPECT_EQ(get("127.0.0.1:8470", origin, "/live"), 403) << origin;
  }
}

TEST(Access, TheTokenIsAskedForBeyondLoopback) {
  const std::string host = "10.0.0.5:8470";
  EXPECT_EQ(get(host, "", "/", kOpen), 403);
  EXPECT_EQ(get(host, "", "/?token=0123456789abcdef0123456789abcdee", kOpen), 403);
  EXPECT_EQ(get(host, "", "/?token=", kOpen), 403);
  const Judgement j = judge({"GET", "/?a=b&token=" + kOpen.token, host, "", "", false, ""}, kOpen);
  EXPECT_EQ(j.status, 200);
  EXPECT_TRUE(j.set_cookie);
  EXPECT_EQ(j.path, "/");
  EXPECT_EQ(get(host, "", "/main.js", kOpen, "x=y; cliquevo_8470=" + kOpen.token), 200);
  EXPECT_EQ(get(host, "", "/main.js", kOpen, "cliquevo_8471=" + kOpen.token), 403);
}

TEST(Access, NothingButReading) {
  EXPECT_EQ(judge({"POST", "/", "localhost:8470", "", "", false, ""}, kLocal).status, 405);
  EXPECT_EQ(judge({"GET", "/", "localhost:8470", "", "", true, ""}, kLocal).status, 404);
}

TEST(Access, ThereIsNoPathOutOfThePagesOwnFiles) {
  EXPECT_NE(find_page_file("/"), nullptr);
  EXPECT_NE(find_page_file("/vendor/three.module.min.js"), nullptr);
  for (const char* path :
       {"/../main.js", "/vendor/../main.js", "//main.js", "main.js", "/vendor/", "", "/etc/passwd"}) {
    EXPECT_EQ(find_page_file(path), nullptr) << path;
  }
}

TEST(Access, CommandsAreFewAndWholeOnes) {
  const auto frame = parse_command(R"({"op":"frame","n":12,"parts":255})");
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->number, 12);
  EXPECT_EQ(frame->parts, 15U);
  EXPECT_EQ(frame->have, -1);
  EXPECT_EQ(parse_command(R"({"op":"frame","n":12,"parts":1,"have":9})")->have, 9);
  EXPECT_EQ(parse_command(R"({"op":"frame","n":12,"parts":1,"have":"9"})")->have, -1);
  EXPECT_TRUE(parse_command(R"({"op":"record-start"})"));
  for (const char* text : {"", "{}", "[]", R"({"op":3})", R"({"op":"frame","n":1.5,"parts":1})",
                           R"({"op":"frame","n":1,"parts":-1})", R"({"op":"reset"})"}) {
    EXPECT_FALSE(parse_command(text)) << text;
  }
  EXPECT_FALSE(parse_command(std::string(kMostCommandBytes + 1, ' ')));
}

}  // namespace
}  // namespace cliquevo::view
