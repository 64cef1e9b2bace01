// SPDX-License-Identifier: BSD-3-Clause
// What is made of the table of checks has all of them: pages, and the numbers in VO_STATUS.
#include <set>
#include <string>

#include <gtest/gtest.h>

#include "core/vo/verdict.h"
#include "tests/support/subprocess.h"

namespace cliquevo::vo {
namespace {

std::string in_tree(const std::string& path) { return test::read_file(std::string(CLIQUEVO_SOURCE_DIR) + "/" + path); }

std::string page_of(const CheckRow& row) {
  std::string page = std::string(row.symbol) + ".md";
  for (char& c : page) c = c == '_' ? '-' : c;
  return page;
}

std::string number_line(const CheckRow& row) {
  std::string line = "const int32_t CHECK_";
  for (const char* c = row.symbol; *c != '\0'; ++c) {
    line += static_cast<char>(*c >= 'a' && *c <= 'z' ? *c - 'a' + 'A' : *c);
  }
  return line + " = " + std::to_string(static_cast<int>(row.check)) + ";";
}

TEST(CheckNames, EachHasARowOfItsOwn) {
  std::set<Check> checks;
  std::set<std::string> symbols;
  std::set<std::string> names;
  for (const CheckRow& row : kCheckRows) {
    EXPECT_LT(row.check, Check::count);
    EXPECT_TRUE(checks.insert(row.check).second) << row.name;
    EXPECT_TRUE(symbols.insert(row.symbol).second) << row.symbol;
    EXPECT_TRUE(names.insert(row.name).second) << row.name;
    EXPECT_STREQ(check_name(row.check), row.name);
    EXPECT_GT(row.status, Status::valid) << row.name;
    for (const char* text : {row.unit, row.meaning, row.question, row.value, row.bound})
      EXPECT_NE(text[0], '\0') << row.name;
  }
  EXPECT_EQ(checks.size(), kChecks) << "a check has no row in core/vo/check_list.h";
}

TEST(CheckNames, PagesAndTheMessageHaveEach) {
  const std::string core = in_tree("core/README.md");
  const std::string pages = in_tree("docs/checks/README.md");
  const std::string message = in_tree("daemon/lcmtypes/status_t.lcm");
  for (const CheckRow& row : kCheckRows) {
    const std::string name = std::string("\n| [") + row.name + "](";
    const std::string verdict = std::string(" | ") + status_name(row.status) + " |\n";
    EXPECT_NE(core.find(name + "../docs/checks/" + page_of(row) + ") | " + row.value + " | " + row.bound + verdict),
              std::string::npos)
        << row.name << " in core/README.md: run tools/generate";
    EXPECT_NE(pages.find(name + page_of(row) + ") | " + row.question + verdict), std::string::npos)
        << row.name << " in docs/checks/README.md: run tools/generate";
    EXPECT_NE(message.find(std::string("  // ") + row.meaning + "\n  " + number_line(row)), std::string::npos)
        << number_line(row) << " in daemon/lcmtypes/status_t.lcm: run tools/generate";
  }
}

}  // namespace
}  // namespace cliquevo::vo
