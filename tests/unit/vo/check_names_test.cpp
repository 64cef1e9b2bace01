// SPDX-License-Identifier: BSD-3-Clause
// Pages go by the names of checks: the view's explanations and the table in core/README.md have all of them.
#include <string>

#include <gtest/gtest.h>

#include "core/vo/verdict.h"
#include "tests/support/subprocess.h"

namespace cliquevo::vo {
namespace {

std::string in_tree(const std::string& path) { return test::read_file(std::string(CLIQUEVO_SOURCE_DIR) + "/" + path); }

// The text of `const NAME = {...}` in a script.
std::string table(const std::string& script, const std::string& name) {
  const std::size_t begin = script.find("const " + name + " = {");
  if (begin == std::string::npos) return {};
  return script.substr(begin, script.find("};", begin) - begin);
}

// Whether the table has the key, as a word or quoted.
bool has_key(const std::string& table, const std::string& key) {
  return table.find(" " + key + ": \"") != std::string::npos || table.find("\"" + key + "\": \"") != std::string::npos;
}

TEST(CheckNames, EachHasAUnitAndAnExplanationInTheView) {
  const std::string page = in_tree("tools/view/page/why.js");
  for (const char* name : {"units", "meanings"}) {
    const std::string entries = table(page, name);
    ASSERT_FALSE(entries.empty()) << name;
    EXPECT_FALSE(has_key(entries, "no such check"));
    for (std::size_t k = 0; k < kChecks; ++k) {
      const std::string check = check_name(static_cast<Check>(k));
      EXPECT_TRUE(has_key(entries, check)) << check << " is missing in " << name << " of tools/view/page/why.js";
    }
  }
}

TEST(CheckNames, EachHasARowInTheReadme) {
  const std::string page = in_tree("core/README.md");
  for (std::size_t k = 0; k < kChecks; ++k) {
    const std::string check = check_name(static_cast<Check>(k));
    EXPECT_NE(page.find("\n| [" + check + "](../docs/checks/"), std::string::npos)
        << check << " is missing in core/README.md";
  }
}

TEST(CheckNames, EachIsAWordOfItsOwn) {
  for (std::size_t k = 0; k < kChecks; ++k) {
    EXPECT_STRNE(check_name(static_cast<Check>(k)), "unknown") << "check " << k << " has no row in verdict.cpp";
    for (std::size_t j = 0; j < k; ++j)
      EXPECT_STRNE(check_name(static_cast<Check>(k)), check_name(static_cast<Check>(j)));
  }
}

}  // namespace
}  // namespace cliquevo::vo
