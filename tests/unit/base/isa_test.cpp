// SPDX-License-Identifier: BSD-3-Clause
#include "core/base/isa.h"

#include <gtest/gtest.h>

namespace cliquevo {
namespace {

TEST(Isa, EverySetIsFoundByItsName) {
  EXPECT_EQ(isas().size(), static_cast<std::size_t>(Isa::count));
  for (const Isa isa : isas()) EXPECT_EQ(isa_by_name(isa_name(isa)), isa) << isa_name(isa);
}

TEST(Isa, EverySetThatTheMachineHasCanBeForced) {
  EXPECT_TRUE(isa_available(Isa::reference));
  for (const Isa isa : isas()) {
    const IsaChoice choice = choose_isa(isa_name(isa));
    EXPECT_EQ(choice.isa, isa_available(isa) ? isa : Isa::reference) << isa_name(isa);
    EXPECT_EQ(choice.complaint.empty(), isa_available(isa)) << choice.complaint;
  }
}

TEST(Isa, NothingForcedGivesTheBestThatTheMachineHas) {
  Isa best = Isa::reference;
  for (const Isa isa : isas()) best = isa_available(isa) ? isa : best;
  for (const char* nothing : {static_cast<const char*>(nullptr), ""}) {
    EXPECT_EQ(choose_isa(nothing).isa, best);
    EXPECT_EQ(choose_isa(nothing).complaint, "");
  }
}

TEST(Isa, AnUnknownNameIsToldWithTheKnownOnesAndGivesTheReference) {
  EXPECT_FALSE(isa_by_name("axv2").has_value());
  EXPECT_FALSE(isa_by_name("").has_value());
  const IsaChoice choice = choose_isa("ax\nv2");
  EXPECT_EQ(choice.isa, Isa::reference);
  EXPECT_NE(choice.complaint.find("CLIQUEVO_ISA=ax v2"), std::string::npos) << choice.complaint;
  EXPECT_EQ(choice.complaint.find('\n'), std::string::npos) << choice.complaint;
  for (const Isa isa : isas()) EXPECT_NE(choice.complaint.find(isa_name(isa)), std::string::npos) << choice.complaint;
}

}  // namespace
}  // namespace cliquevo
