// SPDX-License-Identifier: BSD-3-Clause
// One key, its range and its words; and the tables whose rows must not contradict one another.
#include "daemon/pipeline/keys/key.h"

#include <cmath>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "daemon/pipeline/camera_families.h"
#include "daemon/pipeline/keys/key_reader.h"
#include "daemon/pipeline/lcm_config.h"
#include "daemon/pipeline/source.h"

namespace cliquevo::daemon {
namespace {

TEST(Range, TakesItsEndsUnlessTheyAreOpen) {
  EXPECT_TRUE(between(1, 3).contains(1.0) && between(1, 3).contains(3.0));
  EXPECT_FALSE(between(1, 3).contains(3.001));
  EXPECT_FALSE(above(0).contains(0.0));
  EXPECT_TRUE(above(0).contains(1e-300));
  EXPECT_TRUE(odd_between(5, 21).contains(7) && !odd_between(5, 21).contains(8));
  EXPECT_TRUE(multiple_between(16, 16, 256).contains(64) && !multiple_between(16, 16, 256).contains(65));
  EXPECT_TRUE(any().contains(-1e300));
  EXPECT_FALSE(at_least(0).contains(std::nan(""))) << "not a number is in no range";
}

TEST(Range, SaysWhatItTakes) {
  EXPECT_EQ(odd_between(5, 21).text(), "5 to 21, odd");
  EXPECT_EQ(at_least(0).text(), "0 or more");
  EXPECT_EQ(above(0).text(), "above 0");
  EXPECT_EQ(multiple_between(16, 16, 256).text(), "16 to 256, a multiple of 16");
  EXPECT_EQ(any().text(), "");
}

// A table of one key of each kind.
struct Values {
  bool flag = false;
  int count = 3;
  double number = 1.5;
  std::optional<double> open;
  std::string text = "abc", file, choice = "b";
  double three[3] = {1, 2, 3};

  KeyTable table() {
    KeyTable t;
    t.section("made");
    t.flag("flag", flag, "");
    t.number("count", count, "px", between(1, 9), "");
    t.number("number", number, "m", above(0), "");
    t.number("open", open, "", any(), "");
    t.text("text", text, "", between(1, 5));
    t.file("file", file, "");
    t.choice("choice", choice, {"a", "b"}, "");
    t.triple("three", three, "deg", between(-180, 180), "");
    return t;
  }
};

TEST(Key, ShowsItsValueAndWhatItExpects) {
  Values v;
  const KeyTable t = v.table();
  const std::vector<std::pair<std::string, std::string>> expected = {
      {"false", "true or false"}, {"3", "a whole number"},
      {"1.5", "a number"},        {"auto", "a number or auto"},
      {"abc", "a text"},          {"", "a text"},
      {"b", "one of a, b"},       {"[1, 2, 3]", "three numbers, [a, b, c]"}};
  ASSERT_EQ(t.keys().size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(t.keys()[i].value(), expected[i].first) << t.keys()[i].name;
    EXPECT_EQ(t.keys()[i].expects(), expected[i].second) << t.keys()[i].name;
    EXPECT_TRUE(t.keys()[i].check().ok()) << t.keys()[i].name;
  }
  v.count = 10;
  v.text = "abcdef";
  v.three[2] = 200.0;
  for (const std::size_t i : {1U, 4U, 7U}) {
    const auto ok = t.keys()[i].check();
    ASSERT_FALSE(ok.ok()) << t.keys()[i].name;
    EXPECT_NE(ok.error().where.find(t.keys()[i].name), std::string::npos);
  }
}

TEST(Key, TakesAValueFromAFileOrLeavesTheOldOne) {
  Values v;
  const KeyTable t = v.table();
  const auto read = [&](std::size_t i, const char* yaml) { return read_value(t.keys()[i], YAML::Load(yaml), "/conf"); };
  EXPECT_TRUE(read(0, "true") && v.flag);
  EXPECT_TRUE(read(1, "7") && v.count == 7);
  EXPECT_FALSE(read(1, "7.5"));
  EXPECT_EQ(v.count, 7);
  EXPECT_TRUE(read(3, "2.5") && v.open == 2.5);
  EXPECT_TRUE(read(3, "auto") && !v.open.has_value());
  EXPECT_TRUE(read(5, "rig.yaml"));
  EXPECT_EQ(v.file, "/conf/rig.yaml");
  EXPECT_FALSE(read(6, "c"));
  EXPECT_TRUE(read(6, "a") && v.choice == "a");
  EXPECT_TRUE(read(7, "[4, 5, 6]") && v.three[2] == 6.0);
  EXPECT_FALSE(read(7, "[4, 5]"));
}

TEST(Key, CopiesTheValueOfItsLike) {
  Values from, to;
  from.flag = true;
  from.count = 8;
  from.choice = "a";
  from.file = "x";
  from.three[0] = 9.0;
  const KeyTable a = from.table(), b = to.table();
  for (std::size_t i = 0; i < a.keys().size(); ++i) b.keys()[i].copy_from(a.keys()[i]);
  for (std::size_t i = 0; i < a.keys().size(); ++i) EXPECT_EQ(b.keys()[i].value(), a.keys()[i].value());
  b.keys()[1].copy_from(a.keys()[0]);
  EXPECT_EQ(to.count, 8) << "of another kind: nothing";
}

TEST(CameraFamilies, HaveNamesOfTheirOwnAndThoseThatAreThereAreSources) {
  std::set<std::string> names;
  for (const CameraFamily& family : camera_families()) {
    EXPECT_TRUE(names.insert(family.name).second) << family.name;
    EXPECT_STRNE(family.meaning, "");
    EXPECT_EQ(family.is_built_in(), family.list != nullptr) << family.name;
    EXPECT_EQ(built_in_sources().find(family.name) != std::string::npos, family.is_built_in()) << family.name;
  }
  EXPECT_NE(built_in_sources().find("simulator"), std::string::npos);
}

TEST(LcmChannels, EachIsAFieldOfItsOwnWithADefaultThatFits) {
  std::set<std::string> keys, channels;
  const LcmConfig defaults;
  for (const LcmChannel& channel : kLcmChannels) {
    EXPECT_TRUE(keys.insert(channel.key).second) << channel.key;
    const std::string& name = defaults.*channel.name;
    EXPECT_LE(name.size(), kLongestChannel);
    EXPECT_TRUE(!channel.required || !name.empty()) << channel.key;
    if (!name.empty()) {
      EXPECT_TRUE(channels.insert(name).second) << name << " carries two messages";
    }
  }
}

}  // namespace
}  // namespace cliquevo::daemon
