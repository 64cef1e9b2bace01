// SPDX-License-Identifier: BSD-3-Clause
#include "tools/comparison.h"

#include <algorithm>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace cliquevo::tools {
namespace {

RunFigures good() {
  RunFigures f;
  f.frames = 100;
  f.segments_pct = 0.50;
  f.rotation_deg_m = 0.0100;
  f.end_pct = 0.40;
  f.ate_m = 0.020;
  f.quality = 80;
  f.inliers = 250;
  f.time_ms = 5.0;
  f.time_p95_ms = 6.0;
  return f;
}

bool trips(const RunFigures& a, const RunFigures& b, const Gates& gates = {}) {
  return compare_runs({{"one", a}}, {{"two", b}}, gates).beyond_gate;
}

TEST(Comparison, EqualRunsAreNotWorse) { EXPECT_FALSE(trips(good(), good())); }

TEST(Comparison, EveryFigureOfAccuracyIsJudged) {
  const auto worse = [](auto change) {
    RunFigures b = good();
    change(b);
    return trips(good(), b);
  };
  EXPECT_TRUE(worse([](RunFigures& b) { b.segments_pct = 0.56; }));
  EXPECT_FALSE(worse([](RunFigures& b) { b.segments_pct = 0.54; }));
  EXPECT_FALSE(worse([](RunFigures& b) { b.segments_pct = 0.30; }));
  EXPECT_TRUE(worse([](RunFigures& b) { b.rotation_deg_m = 0.02; }));
  EXPECT_TRUE(worse([](RunFigures& b) { b.ate_m = 0.03; }));
  EXPECT_TRUE(worse([](RunFigures& b) { b.failed = 1; }));
  EXPECT_TRUE(worse([](RunFigures& b) { b.skipped = 1; }));
  EXPECT_TRUE(worse([](RunFigures& b) { b.quality = 60; }));
  EXPECT_FALSE(worse([](RunFigures& b) { b.quality = 90; }));
  EXPECT_TRUE(worse([](RunFigures& b) { b.ate_m.reset(); }));
}

TEST(Comparison, WhatIsTooSmallToMatterIsEqual) {
  RunFigures a = good();
  RunFigures b = good();
  a.ate_m = 0.0001;
  b.ate_m = 0.0009;
  EXPECT_FALSE(trips(a, b));
}

TEST(Comparison, TimesAreJudgedWhenAsked) {
  RunFigures b = good();
  b.time_ms = 10.0;
  EXPECT_FALSE(trips(good(), b));
  EXPECT_TRUE(trips(good(), b, {1.1, 1.5}));
  EXPECT_FALSE(trips(good(), b, {1.1, 2.5}));
}

TEST(Comparison, FoldersGoByNameAndWhatIsMissingIsWorse) {
  const std::vector<NamedRun> both = {{"x", good()}, {"y", good()}};
  const std::vector<NamedRun> one = {{"y", good()}};
  EXPECT_TRUE(compare_runs(both, one, {}).beyond_gate);
  EXPECT_FALSE(compare_runs(one, both, {}).beyond_gate);
  const Comparison c = compare_runs(both, both, {});
  EXPECT_EQ(c.runs.size(), 2U);
  EXPECT_NE(comparison_table(c).find("in all"), std::string::npos);
}

TEST(Comparison, InAllIsTheMeanAndOfCountsTheSum) {
  RunFigures b = good();
  b.segments_pct = 0.70;
  b.failed = 3;
  const Comparison c = compare_runs({{"x", good()}, {"y", good()}}, {{"x", b}, {"y", good()}}, {});
  const auto value = [&c](const std::string& name) {
    const auto& all = c.in_all.figures;
    return std::find_if(all.begin(), all.end(), [&](const ComparedFigure& f) { return f.name == name; })->b.value();
  };
  EXPECT_DOUBLE_EQ(value("segments"), 0.60);
  EXPECT_EQ(value("failed"), 3);
}

TEST(Comparison, WhatIsNoStatisticsIsAnError) {
  for (const char* text : {"", "{}", "[1,2]", "{\"summary\":1,\"frames\":[]}", "{\"summary\":{},\"frames\":[]}",
                           "{\"summary\":{\"frames\":\"x\",\"failed\":0},\"frames\":[]}", "P5 3 3 255"}) {
    EXPECT_FALSE(parse_run(text, "f").ok()) << text;
  }
  EXPECT_TRUE(parse_run("{\"summary\":{\"frames\":2,\"failed\":0},\"frames\":[1,null,{}]}", "f").ok());
  EXPECT_FALSE(read_runs("/nowhere/at/all.json").ok());
}

TEST(Comparison, JsonSaysNullWhereThereIsNoNumber) {
  RunFigures b = good();
  b.failed = 4;
  const auto text = comparison_json(compare_runs({{"x", good()}}, {{"x", b}}, {}), {}).dump();
  EXPECT_EQ(text.find("inf"), std::string::npos);
  EXPECT_NE(text.find("\"times_worse\":null"), std::string::npos);
}

}  // namespace
}  // namespace cliquevo::tools
