// SPDX-License-Identifier: BSD-3-Clause
// The parts of a fleet: sweeps, names, keys, the plan's file, the store.
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <stdexcept>
#include <unistd.h>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/support/test_data.h"
#include "tools/fleet/digest.h"
#include "tools/fleet/engine.h"
#include "tools/fleet/fingerprint.h"
#include "tools/fleet/isolated.h"
#include "tools/fleet/make_plan.h"
#include "tools/fleet/progress_text.h"
#include "tools/fleet/store.h"
#include "tools/fleet/unit_key.h"

namespace cliquevo::tools::fleet {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

TEST(FleetPlan, ASweepIsEveryValueAndCommasInBracketsAndQuotesAreNotIts) {
  EXPECT_EQ(*sweep_values("a.b=1,2"), (Words{"a.b=1", "a.b=2"}));
  EXPECT_EQ(*sweep_values("a.b=[1,2],[3,4]"), (Words{"a.b=[1,2]", "a.b=[3,4]"}));
  EXPECT_EQ(*sweep_values("a.b='x,y'"), (Words{"a.b='x,y'"}));
  EXPECT_EQ(*sweep_values("a.b="), (Words{"a.b="}));
  EXPECT_FALSE(sweep_values("a.b"));
  EXPECT_FALSE(sweep_values("=1"));
}

TEST(FleetPlan, ConfigurationsAreEveryCombinationEachWithANameOfItsOwn) {
  PlanArgument argument;
  argument.settings = {"stereo.window=7,9", "odometry.max_features=100", "stereo.uniqueness_percent=5,10"};
  const auto read = read_configurations(argument);
  ASSERT_TRUE(read) << read.error().line();
  ASSERT_EQ(read->size(), 4U);
  std::set<std::string> names;
  for (const ReadConfiguration& c : *read) {
    names.insert(c.name);
    EXPECT_EQ(c.config.odometry.max_features, 100);
    EXPECT_EQ(c.config.stereo.workers, 1);
  }
  EXPECT_EQ(names.size(), 4U);
  EXPECT_TRUE(names.contains("default stereo.window=9 stereo.uniqueness_percent=5"));
  argument.settings = {"stereo.window=7,7"};
  EXPECT_EQ(read_configurations(argument)->back().name, "default stereo.window=7 (2)");
  argument.settings = {"stereo.window=8"};
  EXPECT_FALSE(read_configurations(argument));
}

TEST(FleetPlan, NamesAreAsShortAsTheyCanBe) {
  EXPECT_EQ(short_names({"/a/x/one", "/a/x/two"}), (Words{"one", "two"}));
  EXPECT_EQ(short_names({"/a/x/run", "/a/y/run", "/b/other"}), (Words{"x/run", "y/run", "other"}));
  EXPECT_EQ(short_names({"sim:frames=3", "/sim"}), (Words{"sim:frames=3", "sim"}));
}

TEST(FleetPlan, ItsFileReadsBackAndNonsenseIsRefused) {
  Plan plan;
  plan.build = sha256("build");
  plan.program = "/usr/bin/cliquevo";
  plan.cache = "/tmp/results";
  plan.recordings = {{"one", "/data/one", 20, 1000, ""}, {"bad", "/data/bad", -1, 0, "no images: /data/bad: look"}};
  plan.configurations = {{"default", "stereo:\n  window: 9\n"}};
  plan.units = {{sha256("a"), 0, 0}};
  const std::string text = plan_text(plan);
  const auto read = parse_plan(text, "here");
  ASSERT_TRUE(read) << read.error().line();
  EXPECT_EQ(plan_text(*read), text);
  EXPECT_EQ(read->unit_name(read->units[0]), "one with default");
  for (const std::string& bad :
       {std::string(), std::string("{}"), std::string("[1,2"), text.substr(0, text.size() / 2)}) {
    EXPECT_FALSE(parse_plan(bad, "here"));
  }
  plan.units[0].recording = 2;
  EXPECT_FALSE(parse_plan(plan_text(plan), "here"));
  plan.units[0] = {"../../etc/passwd", 0, 0};
  EXPECT_FALSE(parse_plan(plan_text(plan), "here"));
}

TEST(FleetPlan, UnitsAsTextReadBack) {
  const std::vector<std::size_t> units{0, 1, 2, 7, 9, 10};
  EXPECT_EQ(units_text(units), "0-2,7,9-10");
  EXPECT_EQ(*parse_units("0-2,7,9-10", 11), units);
  for (const char* bad : {"", "x", "3-1", "0,", "11", "0-11", "-3", "1-2-3"}) EXPECT_FALSE(parse_units(bad, 11)) << bad;
}

TEST(FleetPlan, TaskLinesAreQuotedForTheShell) {
  EXPECT_EQ(quoted("/a/b-c_1.json"), "/a/b-c_1.json");
  EXPECT_EQ(quoted("it's"), "'it'\\''s'");
  EXPECT_EQ(quoted("$(rm)"), "'$(rm)'");
  EXPECT_EQ(quoted(""), "''");
}

TEST(FleetKey, ChangesWithWhatDecidesTheResultAndWithNothingElse) {
  const daemon::Config config = daemon::default_config();
  const auto source = identify_simulated("sim:frames=5", config);
  ASSERT_TRUE(source);
  const std::string key = unit_key("build", config, *source, false);
  EXPECT_EQ(key.size(), 64U);
  EXPECT_EQ(unit_key("build", config, *source, false), key);
  EXPECT_NE(unit_key("other", config, *source, false), key);
  EXPECT_NE(unit_key("build", config, *source, true), key);
  daemon::Config other = config;
  other.stereo.window += 2;
  EXPECT_NE(unit_key("build", other, *source, false), key);
  other = config;
  other.stereo.workers = 7;
  other.lcm.url = "udpm://";
  other.log_level = "error";
  other.control.socket = "/elsewhere";
  EXPECT_EQ(unit_key("build", other, *source, false), key);
  EXPECT_NE(identify_simulated("sim:frames=6", config)->digest, source->digest);
  EXPECT_EQ(identify_simulated("sim:frames=5,cache_dir=none,workers=3", config)->digest, source->digest);
  EXPECT_EQ(identify_simulated("sim:frames=5,every=2", config)->frames, 3);
}

TEST(FleetKey, TheBuildIsKnown) {
  EXPECT_EQ(build_digest().size(), 64U);
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
}

TEST(FleetFingerprint, ShowsAFileThatGrewMovedInTimeOrHasOtherBytesAndNotWhereTheRecordingLies) {
  const std::string folder = test::scratch_dir();
  fs::create_directories(folder + "/run/left");
  const auto put = [&](const std::string& name, const std::string& text) {
    std::ofstream(folder + "/run/" + name) << text;
  };
  put("left/1", std::string(100'000, 'a'));
  put("times", "1 2 3");
  const auto time = fs::last_write_time(folder + "/run/left/1");
  const auto digest = [&](const std::string& name) { return fingerprint_of(folder + "/" + name)->digest; };
  const std::string before = digest("run");
  EXPECT_EQ(digest("run"), before);
  EXPECT_EQ(fingerprint_of(folder + "/run")->bytes, 100'005);
  fs::rename(folder + "/run", folder + "/moved");
  EXPECT_EQ(digest("moved"), before);
  fs::rename(folder + "/moved", folder + "/run");
  // Of the same size and time, with other bytes at its end.
  put("left/1", std::string(99'999, 'a') + "b");
  fs::last_write_time(folder + "/run/left/1", time);
  const std::string other = digest("run");
  EXPECT_NE(other, before);
  fs::last_write_time(folder + "/run/left/1", time + std::chrono::seconds(1));
  EXPECT_NE(digest("run"), other);
  fs::last_write_time(folder + "/run/left/1", time);
  put("more", "");
  EXPECT_NE(digest("run"), other);
  EXPECT_FALSE(fingerprint_of(folder + "/none"));
}

TEST(FleetStore, GivesBackWhatWasWrittenWholeAndNothingElse) {
  const std::string folder = test::scratch_dir() + "/results";
  auto store = Store::open(folder);
  ASSERT_TRUE(store);
  const std::string key = sha256("unit");
  EXPECT_FALSE(store->read(key, Part::result));
  ASSERT_TRUE(store->write(key, Part::result, "{\"frames\":3}\n"));
  EXPECT_EQ(store->read(key, Part::result), "{\"frames\":3}\n");
  EXPECT_FALSE(store->read(key, Part::cost));
  EXPECT_TRUE(store->written_ns(key, Part::result));
  const std::string file = fmt::format("{}/{}/{}.result.json", folder, key.substr(0, 2), key);
  const auto text = [&] {
    std::ifstream in(file);
    return std::string(std::istreambuf_iterator<char>(in), {});
  };
  const std::string good = text();
  // Torn, edited, of another unit.
  for (const std::string& bad :
       {good.substr(0, good.size() - 2), std::string(good).replace(good.find(":3"), 2, ":4"), std::string()}) {
    std::ofstream(file) << bad;
    EXPECT_FALSE(store->read(key, Part::result)) << bad;
  }
  const std::string other = sha256("other");
  fs::create_directories(fmt::format("{}/{}", folder, other.substr(0, 2)));
  std::ofstream(fmt::format("{}/{}/{}.result.json", folder, other.substr(0, 2), other)) << good;
  EXPECT_FALSE(store->read(other, Part::result));
}

TEST(FleetIsolation, ACrashAnErrorAndAnExceptionEndNothingElse) {
  const Error crash{"it crashed", "here", "see"};
  EXPECT_FALSE(run_isolated([]() -> Result<void> { return {}; }, crash).error);
  const IsolatedEnd failed = run_isolated([]() -> Result<void> { return Error{"a", "b: c", "d"}; }, crash);
  ASSERT_TRUE(failed.error);
  EXPECT_EQ(failed.error->line(), "a: b: c: d");
  EXPECT_FALSE(failed.crashed);
  const IsolatedEnd thrown = run_isolated([]() -> Result<void> { throw std::runtime_error("why"); }, crash);
  EXPECT_EQ(thrown.error->remedy, "why");
  const IsolatedEnd killed = run_isolated(
      []() -> Result<void> {
        std::fputs("last words\n", stderr);
        ::raise(SIGKILL);
        return {};
      },
      crash);
  EXPECT_TRUE(killed.crashed);
  EXPECT_EQ(killed.error->what, "it crashed (signal 9, Killed)");
  EXPECT_EQ(killed.said, "last words\n");
  EXPECT_TRUE(run_isolated([]() -> Result<void> { ::_exit(7); }, crash).crashed);
}

TEST(FleetStatus, RateAndTimeLeftAreThoseOfTheFramesSinceTheRunBegan) {
  Standing s;
  s.units = 10;
  s.done = 4;
  EXPECT_EQ(standing_text(s), "4 of 10 units, time left not known yet");
  s.failed = 1;
  s.done_since = 2;
  s.frames_since = 200;
  s.frames_left = 3000;
  s.elapsed_s = 4;
  EXPECT_EQ(standing_text(s), "4 of 10 units, 1 failed, 30 a minute, 1:00 left");
  EXPECT_EQ(duration_text(3723.0), "1:02:03");
}

}  // namespace
}  // namespace cliquevo::tools::fleet
