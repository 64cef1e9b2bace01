// SPDX-License-Identifier: BSD-3-Clause
// The files that are written from the table of configuration keys are as they would be written now.
#include "tools/config_pages.h"

#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "daemon/pipeline/config.h"
#include "tests/support/subprocess.h"

namespace cliquevo::tools {
namespace {

std::string in_tree(const std::string& path) { return test::read_file(std::string(CLIQUEVO_SOURCE_DIR) + "/" + path); }

TEST(ConfigPages, TheFilesInTheTreeAreUpToDate) {
  EXPECT_EQ(in_tree("config/cliquevo.yaml"), config_sample()) << "run tools/generate";
  EXPECT_EQ(in_tree("config/cliquevo.schema.json"), config_schema()) << "run tools/generate";
  EXPECT_EQ(in_tree("docs/configuration.md"), config_page()) << "run tools/generate";
}

TEST(ConfigPages, TheSampleReadsBackToTheDefaults) {
  const auto read = daemon::parse_config(config_sample(), "sample.yaml");
  ASSERT_TRUE(read.ok()) << read.error().line();
  EXPECT_EQ(daemon::list_config(*read), daemon::list_config(daemon::default_config()));
}

TEST(ConfigPages, TheSchemaKnowsTypeRangeAndNames) {
  const auto schema = nlohmann::json::parse(config_schema());
  const auto& stereo = schema["properties"]["stereo"]["properties"];
  EXPECT_EQ(stereo["window"]["type"], "integer");
  EXPECT_EQ(stereo["window"]["minimum"], 5.0);
  EXPECT_EQ(stereo["window"]["maximum"], 21.0);
  EXPECT_EQ(stereo["prefilter"]["enum"][0], "none");
  EXPECT_EQ(schema["properties"]["rectify"]["properties"]["scale"]["anyOf"][1]["const"], "auto");
  EXPECT_EQ(schema["properties"]["source"]["properties"]["cameras"]["properties"]["left"]["type"][0], "string");
}

}  // namespace
}  // namespace cliquevo::tools
