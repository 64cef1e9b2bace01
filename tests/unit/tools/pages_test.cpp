// SPDX-License-Identifier: BSD-3-Clause
// Man pages and completion, as written from the options.
#include <string>

#include <CLI/CLI.hpp>
#include <gtest/gtest.h>

#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"
#include "tools/completion.h"
#include "tools/man_page.h"
#include "tools/option_tree.h"

namespace cliquevo::tools {
namespace {

struct Example {
  mutable CLI::App app{"Plays 'things': see .below", "player"};
  std::string file;
  std::string format = "kitti";
  bool strict = false;

  Example() {
    app.footer("Example:\n  player run in.txt --format tum");
    CLI::App* run = app.add_subcommand("run", "Run one");
    run->add_option("SOURCE", file, "What to play")->required();
    run->add_option("--format", format, "Of the output [px]")
        ->check(CLI::IsMember({"kitti", "tum"}))
        ->capture_default_str();
    run->add_option("--out", file, ".hidden \\ -x")->type_name("FILE");
    run->add_option("--set", file, "One key")->type_name("KEY=VALUE");
    CLI::App* inner = run->add_subcommand("inner", "Deeper");
    inner->add_flag("--strict", strict, "Strictly");
  }
};

CompletionWords words(const Example& example) {
  return {{describe_app(CliCommand(example.app))}, {"a.b=true", "a.b=false", "a.c="}};
}

// What bash offers behind these words; the last one is being typed.
std::string offered(const std::string& script, const std::string& line, const std::string& count) {
  const test::Finished done = test::run({"bash", "-c",
                                         ". '" + script + "'; COMP_WORDS=(" + line + "); COMP_CWORD=" + count +
                                             "; _cliquevo player; echo ${COMPREPLY[*]}"});
  EXPECT_EQ(done.err, "");
  return done.out;
}

std::string written(const std::string& name, const std::string& text) {
  const std::string path = test::scratch_dir() + "/" + name;
  std::FILE* file = std::fopen(path.c_str(), "w");
  std::fputs(text.c_str(), file);
  std::fclose(file);
  return path;
}

TEST(OptionTree, HasEveryCommandAndOption) {
  const Example example;
  const CommandInfo player = describe_app(CliCommand(example.app));
  ASSERT_EQ(flattened(player).size(), 3U);
  EXPECT_EQ(flattened(player)[2]->path, "player run inner");
  const CommandInfo& run = player.commands.at(0);
  ASSERT_EQ(run.options.size(), 5U);  // with --help
  EXPECT_TRUE(run.options[1].positional && run.options[1].required);
  EXPECT_EQ(run.options[2].choices, (std::vector<std::string>{"kitti", "tum"}));
  EXPECT_EQ(run.options[2].standard, "kitti");
  EXPECT_TRUE(run.options[3].takes_file());
}

TEST(ManPage, IsReadByManWithoutAWarning) {
  const Example example;
  const std::string path = written("player.1", man_page(describe_app(CliCommand(example.app)), 1, "1.2.3"));
  const test::Finished shown =
      test::run({"man", "--warnings", "-l", path}, {{"MANWIDTH", "100"}, {"LC_ALL", "C.UTF-8"}, {"PAGER", "cat"}});
  EXPECT_EQ(shown.exit_code, 0);
  EXPECT_EQ(shown.err, "");
  for (const char* text : {"Plays 'things': see .below", "player run inner", "--format", "(default kitti)",
                           ".hidden \\ -x", "  player run in.txt --format tum"}) {
    EXPECT_NE(shown.out.find(text), std::string::npos) << text << "\n" << shown.out;
  }
}

TEST(Completion, BashOffersWhatFits) {
  const Example example;
  const std::string script = written("player.bash", bash_completion(words(example)));
  EXPECT_EQ(offered(script, "player r", "1"), "run\n");
  EXPECT_EQ(offered(script, "player run --fo", "2"), "--format\n");
  EXPECT_EQ(offered(script, "player run --format ''", "3"), "kitti tum\n");
  EXPECT_EQ(offered(script, "player run inner --s", "3"), "--strict\n");
  EXPECT_EQ(offered(script, "player run --set a.", "3"), "a.b=true a.b=false a.c=\n");
  EXPECT_EQ(offered(script, "player run --set a.b =", "4"), "true false\n");
  EXPECT_EQ(offered(script, "player run --set a.b = f", "5"), "false\n");
}

TEST(Completion, ZshAndFishTakeTheirFiles) {
  const Example example;
  const std::string zsh = written("_player", zsh_completion(words(example)));
  const test::Finished by_zsh = test::run({"zsh", "-n", zsh});
  EXPECT_EQ(by_zsh.exit_code, 0) << by_zsh.err;
  const std::string fish = written("player.fish", fish_completion(words(example)));
  const test::Finished by_fish =
      test::run({"fish", "--no-config", "-c", "source " + fish + "; complete -C 'player run --format '"});
  // Each with its option's meaning behind a tab.
  EXPECT_EQ(by_fish.out, "kitti\tOf the output [px]\ntum\tOf the output [px]\n") << by_fish.err;
  EXPECT_EQ(by_fish.err, "");
}

}  // namespace
}  // namespace cliquevo::tools
