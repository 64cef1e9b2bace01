// SPDX-License-Identifier: BSD-3-Clause
// `cliquevo compare` on runs of the real pipeline: a setting that makes it worse trips the gate, the same run does not.
#include <fstream>

#include <nlohmann/json.hpp>

#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {
namespace {

std::string stats_of(const std::string& folder, const std::string& name, const std::string& config) {
  std::ofstream(folder + "/" + name + ".yaml") << config;
  const std::string stats = folder + "/" + name + ".json";
  const Finished done =
      run({binary("cliquevo"), "replay", "sim:frames=80", "--config", folder + "/" + name + ".yaml", "--stats", stats});
  EXPECT_EQ(done.exit_code, 0) << done.err;
  return stats;
}

TEST(Compare, FewerFeaturesTripTheGateAndEqualRunsDoNot) {
  const std::string folder = scratch_dir();
  const std::string a = stats_of(folder, "a", "odometry: {max_features: 350}\n");
  const std::string again = stats_of(folder, "again", "odometry: {max_features: 350}\n");
  const std::string few = stats_of(folder, "few", "odometry: {max_features: 50}\n");
  const Finished same = run({binary("cliquevo"), "compare", a, again});
  EXPECT_EQ(same.exit_code, 0) << same.out << same.err;
  const Finished worse = run({binary("cliquevo"), "compare", a, few, "--gate", "1.10", "--out", folder + "/c.json"});
  EXPECT_EQ(worse.exit_code, 3) << worse.out;
  EXPECT_EQ(lines_of(worse.err).size(), 1U);
  EXPECT_NE(worse.out.find("beyond the gate"), std::string::npos);
  EXPECT_TRUE(nlohmann::json::parse(read_file(folder + "/c.json"))["beyond_gate"].get<bool>());
}

TEST(Compare, WhatIsNoStatisticsIsOneLine) {
  const std::string folder = scratch_dir();
  std::ofstream(folder + "/x.json") << "{\"frames\": 3}";
  for (const std::string& path : {folder + "/x.json", folder + "/none.json", std::string("/dev/null"), folder}) {
    const Finished done = run({binary("cliquevo"), "compare", path, path});
    EXPECT_EQ(done.exit_code, 1) << path;
    EXPECT_EQ(lines_of(done.err).size(), 1U) << done.err;
  }
  EXPECT_EQ(run({binary("cliquevo"), "compare", folder, folder, "--gate", "0.5"}).exit_code, 2);
}

}  // namespace
}  // namespace cliquevo::test
