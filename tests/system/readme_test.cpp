// SPDX-License-Identifier: BSD-3-Clause
// The README's own lines: what can be run is run, what cannot is there.
#include <filesystem>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {
namespace {

namespace fs = std::filesystem;

std::string in_tree(const std::string& path) { return std::string(CLIQUEVO_SOURCE_DIR) + "/" + path; }

// Lines of all blocks of a language.
std::vector<std::string> lines_of_blocks(const std::string& language) {
  std::vector<std::string> out;
  bool inside = false;
  for (const std::string& line : lines_of(read_file(in_tree("README.md")))) {
    if (line.starts_with("```")) {
      inside = !inside && line == "```" + language;
    } else if (inside && !line.empty()) {
      out.push_back(line);
    }
  }
  return out;
}

std::string first_word(const std::string& line) { return line.substr(0, line.find(' ')); }

// `text` with every `from` as `to`.
std::string replaced(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
  return text;
}

TEST(Readme, TheCommandsThatItNamesRun) {
  const std::string dir = scratch_dir();
  const Environment environment{{"PATH", fs::path(binary("cliquevo")).parent_path().string() + ":/usr/bin:/bin"}};
  const Finished made = run({binary("cliquevo"), "simulate", "--out", dir + "/my_drive", "--frames", "4"});
  ASSERT_EQ(made.exit_code, 0) << made.err;
  int ran = 0;
  for (const std::string& line : lines_of_blocks("sh")) {
    const std::string program = first_word(line);
    if (program == "apt" || program == "systemctl") continue;  // tests of the packages and of the service do
    if (program.starts_with("tools/")) {
      EXPECT_TRUE(fs::exists(in_tree(program))) << line;
      continue;
    }
    ASSERT_TRUE(program == "cliquevo" || program == "cliquevod") << line;
    ++ran;
    const Finished done =
        Subprocess({"bash", "-c", "cd '" + dir + "' && " + replaced(line, "/data/my_drive", dir + "/my_drive")},
                   environment)
            .wait(120.0);
    const bool no_camera = done.err.starts_with("no camera found");  // here is none
    EXPECT_TRUE(done.exit_code == 0 || no_camera) << line << "\n" << done.err;
  }
  EXPECT_GE(ran, 3);
  EXPECT_EQ(lines_of(read_file(dir + "/poses.txt")).size(), 4U);
  EXPECT_TRUE(fs::exists(dir + "/run.html"));
}

// The C++ lines are those of a program that another test builds and runs; so are the Python ones.
TEST(Readme, TheLinesOfCodeAreThoseOfTheExamples) {
  const Finished check = run({"python3", in_tree("tools/readme_examples"), "--check"});
  EXPECT_EQ(check.exit_code, 0) << check.err;
  EXPECT_GE(lines_of_blocks("cpp").size(), 8U);
  EXPECT_GE(lines_of_blocks("python").size(), 4U);
}

TEST(Readme, ThePagesAndPicturesThatItNamesAreThere) {
  const std::string text = read_file(in_tree("README.md"));
  int links = 0;
  for (std::size_t at = 0; (at = text.find("](", at)) != std::string::npos; ++at) {
    const std::string target = text.substr(at + 2, text.find(')', at) - at - 2);
    if (target.starts_with("http")) continue;
    ++links;
    EXPECT_TRUE(fs::exists(in_tree(target))) << target;
  }
  EXPECT_GT(links, 10);
}

}  // namespace
}  // namespace cliquevo::test
