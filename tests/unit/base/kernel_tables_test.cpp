// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/kernel_tables.h"

#include <gtest/gtest.h>

namespace cliquevo {
namespace {

struct Table {
  int (*first)();
  int (*second)();
};
constexpr Table kReference{.first = [] { return 1; }, .second = [] { return 2; }};

#if defined(__x86_64__)
constexpr Isa kLow = Isa::sse4;
constexpr Isa kHigh = Isa::avx2;
#else
constexpr Isa kLow = Isa::reference;
constexpr Isa kHigh = Isa::neon;
#endif

TEST(KernelTables, ASetOverridesByNameAndKeepsTheRestOfTheSetBelow) {
  if (!isa_available(kHigh)) GTEST_SKIP() << "this machine has no " << isa_name(kHigh);
  const KernelTables<Table> tables(kReference, {{kLow, [](Table& t) { t.first = [] { return 10; }; }},
                                                {kHigh, [](Table& t) { t.second = [] { return 20; }; }}});
  EXPECT_EQ(tables.reference().first(), 1);
  EXPECT_EQ(tables.find(kHigh)->first(), 10);
  EXPECT_EQ(tables.find(kHigh)->second(), 20);
  EXPECT_EQ(tables.usable().front(), Isa::reference);
  EXPECT_EQ(tables.usable().size(), 3U);
}

TEST(KernelTables, ASetWithoutKernelsOfItsOwnUsesThoseBelow) {
  const KernelTables<Table> tables(kReference, {});
  EXPECT_EQ(tables.active().first(), 1);
  EXPECT_EQ(tables.find(active_isa()), &tables.reference());
}

TEST(KernelTables, ASetThatTheMachineLacksIsNotThere) {
  const KernelTables<Table> tables(kReference, {});
  for (const Isa isa : isas()) {
    EXPECT_EQ(tables.find(isa) != nullptr, isa_available(isa)) << isa_name(isa);
  }
}

}  // namespace
}  // namespace cliquevo
