// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/printable.h"

#include <new>
#include <stdexcept>

#include <gtest/gtest.h>

#include "core/base/caught.h"
#include "core/base/saturating.h"

namespace cliquevo {
namespace {

TEST(Printable, KeepsTextAndLosesWhatATerminalWouldObey) {
  EXPECT_EQ(printable("camera Käfer 1/2 \xE2\x82\xAC"), "camera Käfer 1/2 \xE2\x82\xAC");
  EXPECT_EQ(printable("a\x1b[31mb"), "a?[31mb");
  EXPECT_EQ(printable("two\nlines\r\tand"), "two lines  and");
  EXPECT_EQ(printable(std::string_view("\0\x07\x7f", 3)), "???");
  EXPECT_EQ(printable("C1: \xC2\x9B"
                      "31m"),
            "C1: ?31m");
  EXPECT_EQ(printable("8 bit: \x9B"
                      "31m"),
            "8 bit: ?31m");
  EXPECT_EQ(printable("cut: \xE2\x82"), "cut: ??");
  EXPECT_EQ(printable(""), "");
}

TEST(Caught, EveryExceptionBecomesAnErrorWithThreeParts) {
  const auto thrown = [](auto exception) { return guarded("here", [&]() -> Result<int> { throw exception; }); };
  for (const auto& result : {thrown(std::bad_alloc()), thrown(std::runtime_error("the folder is gone")), thrown(7)}) {
    ASSERT_FALSE(result.ok());
    EXPECT_EQ(result.error().where, "here");
    EXPECT_FALSE(result.error().what.empty());
    EXPECT_FALSE(result.error().remedy.empty());
  }
  EXPECT_EQ(thrown(std::runtime_error("the folder is gone")).error().remedy, "the folder is gone");
  EXPECT_TRUE(is_caught(thrown(7).error()));
  EXPECT_FALSE(is_caught({"no such file", "here", "check the name"}));
  EXPECT_EQ(*guarded("here", []() -> Result<int> { return 3; }), 3);
}

TEST(Caught, AThreadThatMustLiveGoesOnAfterEachException) {
  const std::atomic<bool> stop{false};
  int calls = 0;
  int reported = 0;
  keep_going(
      "here", stop,
      [&] {
        if (++calls < 3) throw std::runtime_error("again");
      },
      [&](const Error&) {
        ++reported;
        throw std::runtime_error("cannot even tell");
      });
  EXPECT_EQ(calls, 3);
  EXPECT_EQ(reported, 2);
}

TEST(Saturating, SumsAndDistancesStayInRange) {
  EXPECT_EQ(saturated_sum(INT64_MAX, 1), INT64_MAX);
  EXPECT_EQ(saturated_sum(INT64_MIN, -1), INT64_MIN);
  EXPECT_EQ(saturated_sum(-3, 5), 2);
  EXPECT_EQ(saturated_distance(INT64_MIN, INT64_MAX), INT64_MAX);
  EXPECT_EQ(saturated_distance(INT64_MAX, INT64_MIN), INT64_MAX);
  EXPECT_EQ(saturated_distance(7, -2), 9);
}

}  // namespace
}  // namespace cliquevo
