// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "drivers/simulator.h"

namespace cliquevo::drivers {
namespace {

TEST(SimulatorOptions, DefaultsAreValid) { EXPECT_TRUE(SimulatorOptions{}.check().ok()); }

TEST(SimulatorOptions, EveryGivenKeyIsTaken) {
  const auto o = parse_simulator_options(
      "course=walking,frames=400,every=2,world_seed=7,noise_seed=9,noise_sigma=1.5,shot_noise=off,movers=3,shadow=yes,"
      "misalign_right_deg=0.1:-0.2:0.3,cache_dir=none,workers=1");
  ASSERT_TRUE(o.ok()) << o.error().line();
  EXPECT_EQ(o->course, "walking");
  EXPECT_EQ(o->frames, 400);
  EXPECT_EQ(o->every, 2);
  EXPECT_EQ(o->world_seed, 7U);
  EXPECT_EQ(o->noise_seed, 9U);
  EXPECT_EQ(o->noise_sigma, 1.5);
  EXPECT_FALSE(o->shot_noise);
  EXPECT_EQ(o->movers, 3);
  EXPECT_TRUE(o->shadow);
  EXPECT_EQ(o->misalign_right_deg[1], -0.2);
  EXPECT_EQ(o->cache_dir, "none");
}

TEST(SimulatorOptions, UnknownKeyIsNamedWithThoseThatExist) {
  const auto o = parse_simulator_options("course=walking,fames=400");
  ASSERT_FALSE(o.ok());
  EXPECT_NE(o.error().where.find("'fames'"), std::string::npos) << o.error().line();
  EXPECT_NE(o.error().remedy.find("frames"), std::string::npos) << o.error().line();
  EXPECT_NE(o.error().remedy.find("noise_seed"), std::string::npos) << o.error().line();
}

TEST(SimulatorOptions, BadValuesAreNamed) {
  for (const char* text : {"frames=many", "frames=0", "frames", "course=flying", "scene=moon", "fault=all",
                           "fault_frames=-2", "width=3", "noise_sigma=nan", "rate_hz=0", "misalign_right_deg=1:2",
                           "shadow=perhaps", "every=-1", "baseline_m=1e9", "frames=12x"}) {
    const auto o = parse_simulator_options(text);
    ASSERT_FALSE(o.ok()) << text;
    const std::string key = std::string(text).substr(0, std::string(text).find('='));
    EXPECT_NE(o.error().where.find(key), std::string::npos) << text << " -> " << o.error().line();
  }
}

}  // namespace
}  // namespace cliquevo::drivers
