// SPDX-License-Identifier: BSD-3-Clause
// `cliquevo fleet` on one machine: whole, and with all that goes wrong.
#include <fstream>
#include <unistd.h>

#include "tests/system/fleet_rig.h"

namespace cliquevo::test {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// Our warnings and errors, and nothing else that is on stderr.
void expect_one_line(const Finished& done, int exit_code, const std::string& with) {
  EXPECT_EQ(done.exit_code, exit_code) << done.out << done.err;
  EXPECT_EQ(lines_of(done.err).size(), 1U) << done.err;
  EXPECT_NE(done.err.find(with), std::string::npos) << done.err;
}

std::vector<std::string> words(std::vector<std::string> first, const std::vector<std::string>& more) {
  first.insert(first.end(), more.begin(), more.end());
  return first;
}

// A recording on disk, of a few small frames.
std::string made_recording(const std::string& folder, const std::string& name, int seed) {
  const std::string path = folder + "/" + name;
  const Finished made =
      run({binary("cliquevo"), "simulate", "--out", path, "--width", "160", "--height", "120", "--focal-px", "175",
           "--frames", "8", "--noise-seed", fmt::format("{}", seed), "--cache-dir", "none"});
  EXPECT_EQ(made.exit_code, 0) << made.err;
  return path;
}

TEST(Fleet, EveryRecordingIsPlayedWithEveryConfigurationAndTheSecondRunComputesNothing) {
  const std::string folder = scratch_dir() + "/fleet";
  const Finished first = fleet(
      "run", folder, words(small_courses(3), {"--set", "stereo.window=7,9", "--set", "odometry.max_features=200"}));
  EXPECT_EQ(first.exit_code, 0) << first.out << first.err;
  EXPECT_NE(first.out.find("6 units: 3 recordings with 2 configurations; 6 to compute"), std::string::npos)
      << first.out;
  const auto results = results_in(folder);
  ASSERT_EQ(results.size(), 6U);
  std::map<std::string, fs::file_time_type> times;
  for (const auto& entry : fs::recursive_directory_iterator(folder + "/results")) {
    times[entry.path().string()] = entry.last_write_time();
  }
  const Finished second = fleet("run", folder);
  EXPECT_EQ(second.exit_code, 0) << second.err;
  EXPECT_NE(second.out.find("; 0 to compute"), std::string::npos) << second.out;
  // A wider sweep computes what is new of it.
  const Finished wider = fleet(
      "run", folder, words(small_courses(3), {"--set", "stereo.window=7,9,11", "--set", "odometry.max_features=200"}));
  EXPECT_NE(wider.out.find("9 units: 3 recordings with 3 configurations; 3 to compute"), std::string::npos)
      << wider.out;
  for (const auto& [path, time] : times) {
    if (!fs::is_regular_file(path)) continue;
    EXPECT_EQ(fs::last_write_time(path), time) << path;
  }
  const json status = json::parse(fleet("status", folder, {"--json"}).out);
  EXPECT_EQ(status["done"], 9);
  EXPECT_EQ(status["waiting"], 0);
}

TEST(Fleet, ResultsAreTheSameBytesHoweverTheyAreComputed) {
  const std::string folder = scratch_dir();
  const auto sources = words(small_courses(6), {"--set", "stereo.window=7,9", "--trajectories"});
  const Finished one = fleet("run", folder + "/one", words({"-j", "1"}, sources));
  EXPECT_EQ(one.exit_code, 0) << one.err;
  const Finished two = fleet("run", folder + "/two", words({"-j", "3", "--units-per-task", "2"}, sources));
  EXPECT_EQ(two.exit_code, 0) << two.err;
  const Finished lines = fleet("run", folder + "/three", words({"--on", "print"}, sources));
  EXPECT_EQ(lines_of(lines.out).size(), 12U) << lines.out;
  for (const std::string& line : lines_of(lines.out)) EXPECT_EQ(run({"sh", "-c", line}).exit_code, 0) << line;
  const auto results = results_in(folder + "/one");
  ASSERT_EQ(results.size(), 12U);
  EXPECT_EQ(results_in(folder + "/two"), results);
  EXPECT_EQ(results_in(folder + "/three"), results);
  // And as replay computes it.
  const Finished replay = run({binary("cliquevo"), "replay", small_course(1), "--set", "stereo.window=7",
                               "--trajectory", folder + "/replay.txt"});
  ASSERT_EQ(replay.exit_code, 0) << replay.err;
  const std::string poses = read_file(folder + "/replay.txt");
  int equal = 0;
  for (const auto& [name, text] : files_ending(folder + "/one", ".poses.txt")) equal += text == poses ? 1 : 0;
  EXPECT_EQ(equal, 1);
}

TEST(Fleet, TheReportHasEveryUnitAndLinksTheWorstFramesToPages) {
  const std::string folder = scratch_dir() + "/fleet";
  const std::string bad = small_course(9, 30) + ",fault=blank,fault_first=12,fault_frames=4";
  ASSERT_EQ(fleet("run", folder, words({bad}, small_courses(2))).exit_code, 0);
  const Finished done = fleet("report", folder, {"--pages", "1"});
  ASSERT_EQ(done.exit_code, 0) << done.err;
  const json report = report_of(folder);
  ASSERT_EQ(report["table"].size(), 3U) << done.out;
  ASSERT_FALSE(report["worst"].empty());
  EXPECT_EQ(report["worst"][0]["recording"], bad);
  const std::string page = report["worst"][0]["page"];
  EXPECT_GT(fs::file_size(folder + "/" + page), 10'000U);
  EXPECT_GT(report["reasons"].size(), 0U);
  EXPECT_GT(report["cost"]["units_an_hour_a_core"].get<double>(), 0.0);
  const std::string html = read_file(folder + "/report.html");
  EXPECT_NE(html.find("cliquevo/fleet.js"), std::string::npos);
  EXPECT_EQ(html.find("src=\"http"), std::string::npos);
  EXPECT_EQ(html.find("href=\"http"), std::string::npos);
}

TEST(Fleet, AWorseConfigurationTripsTheGate) {
  const std::string folder = scratch_dir() + "/fleet";
  std::vector<std::string> courses{"sim:frames=60,noise_seed=1", "sim:frames=60,noise_seed=2"};
  ASSERT_EQ(fleet("run", folder, words(courses, {"--set", "odometry.max_features=350,50"})).exit_code, 0);
  const std::string good = "default odometry.max_features=350";
  const Finished worse = fleet("report", folder, {"--baseline", good, "--pages", "0"});
  expect_one_line(worse, 3, "worse than the gate");
  EXPECT_TRUE(report_of(folder)["comparisons"][0]["comparison"]["beyond_gate"].get<bool>());
  // Another fleet as the baseline: the same build is as good as itself.
  const std::string again = scratch_dir() + "/again";
  ASSERT_EQ(
      fleet("run", again, words(courses, {"--set", "odometry.max_features=350,50", "--cache", folder + "/results"}))
          .exit_code,
      0);
  EXPECT_EQ(fleet("report", again, {"--baseline", folder, "--pages", "0"}).exit_code, 0);
  expect_one_line(fleet("report", folder, {"--baseline", "nothing"}), 1, "no such baseline");
}

TEST(Fleet, AUnitThatCrashesIsReportedAndStopsNoOther) {
  const std::string folder = scratch_dir();
  const std::string crashing = made_recording(folder, "crashing", 1);
  const std::string good = made_recording(folder, "good", 2);
  const Environment loaded{{"LD_PRELOAD", CLIQUEVO_CRASH_ON_OPEN}, {"ASAN_OPTIONS", "verify_asan_link_order=0"}};
  ASSERT_EQ(fleet("plan", folder + "/fleet", {crashing, good, small_course(1)}, loaded).exit_code, 0);
  Environment bad = loaded;
  bad.emplace_back("CRASH_ON_OPEN", "crashing/image_0/000005");
  const Finished done = fleet("run", folder + "/fleet", {}, bad);
  EXPECT_EQ(done.exit_code, 1);
  ASSERT_EQ(lines_of(done.err).size(), 2U) << done.err;  // the unit's, and that one has no result
  EXPECT_NE(done.err.find("the unit crashed (signal 11"), std::string::npos) << done.err;
  EXPECT_NE(done.err.find("crashing with default"), std::string::npos) << done.err;
  EXPECT_NE(done.err.find("about to crash, as intended"), std::string::npos) << done.err;
  EXPECT_EQ(results_in(folder + "/fleet").size(), 2U);
  ASSERT_EQ(fleet("report", folder + "/fleet", {"--pages", "0"}, loaded).exit_code, 0);
  const json report = report_of(folder + "/fleet");
  EXPECT_EQ(report["units"]["failed"], 1);
  EXPECT_EQ(report["failures"][0]["units"][0]["recording"], "crashing");
  // It is tried again, and nothing else is.
  const Finished again = fleet("run", folder + "/fleet", {}, loaded);
  EXPECT_EQ(again.exit_code, 0) << again.err;
  EXPECT_NE(again.out.find("; 1 to compute"), std::string::npos) << again.out;
  ASSERT_EQ(fleet("report", folder + "/fleet", {"--pages", "0"}, loaded).exit_code, 0);
  EXPECT_EQ(report_of(folder + "/fleet")["units"]["failed"], 0);
}

TEST(Fleet, ARecordingThatVanishesOrChangesIsOneLine) {
  const std::string folder = scratch_dir();
  const std::string gone = made_recording(folder, "gone", 1);
  const std::string changed = made_recording(folder, "changed", 2);
  ASSERT_EQ(fleet("plan", folder + "/fleet", {gone, changed, small_course(1)}).exit_code, 0);
  fs::rename(gone, folder + "/elsewhere");
  std::ofstream(changed + "/image_0/000003.png", std::ios::app) << "x";
  const Finished done = fleet("run", folder + "/fleet");
  EXPECT_EQ(done.exit_code, 1);
  EXPECT_EQ(lines_of(done.err).size(), 3U) << done.err;
  EXPECT_NE(done.err.find("gone with default"), std::string::npos) << done.err;
  EXPECT_NE(done.err.find("not what was planned"), std::string::npos) << done.err;
  EXPECT_EQ(results_in(folder + "/fleet").size(), 1U);
  expect_one_line(fleet("plan", folder + "/none", {folder + "/nowhere"}), 1, "no recording can be opened");
  // Beside others it is left out, with a line.
  const Finished beside = fleet("plan", folder + "/some", {folder + "/nowhere", small_course(1)});
  expect_one_line(beside, 0, "left out");
}

TEST(Fleet, AFolderOfRecordingsIsAllOfThemAndAGlobIsWhatItMatches) {
  const std::string folder = scratch_dir();
  fs::create_directories(folder + "/season/torn");
  made_recording(folder + "/season", "one", 1);
  made_recording(folder + "/season", "two", 2);
  std::ofstream(folder + "/season/notes.txt") << "rain";
  const Finished all = fleet("plan", folder + "/all", {folder + "/season"});
  expect_one_line(all, 0, "torn");
  EXPECT_NE(all.out.find("2 units: 3 recordings"), std::string::npos) << all.out;
  const Finished some = fleet("plan", folder + "/some", {folder + "/season/t*o"});
  EXPECT_NE(some.out.find("1 units: 1 recordings"), std::string::npos) << some.out << some.err;
  // One recording is itself, and so is one alone in its folder.
  const Finished one = fleet("plan", folder + "/one", {folder + "/season/one"});
  EXPECT_NE(one.out.find("1 units: 1 recordings"), std::string::npos) << one.out << one.err;
  std::ofstream(folder + "/list") << "# this week\n" << folder << "/season/two\n\n" << small_course(1) << "\n";
  const Finished listed = fleet("plan", folder + "/listed", {"@" + folder + "/list"});
  EXPECT_NE(listed.out.find("2 units: 2 recordings"), std::string::npos) << listed.out << listed.err;
}

TEST(Fleet, AnotherBuildOnANodeComputesNothing) {
  const std::string folder = scratch_dir();
  ASSERT_EQ(fleet("plan", folder + "/fleet", {small_course(1), small_course(2)}).exit_code, 0);
  const std::string line = lines_of(fleet("run", folder + "/fleet", {"--on", "print", "--units-per-task", "2"}).out)[0];
  const Finished done = run({"sh", "-c", line}, {{"LD_PRELOAD", CLIQUEVO_CRASH_ON_OPEN}});
  expect_one_line(done, 1, "another build of cliquevo, or of a library, than the plan's");
  EXPECT_TRUE(results_in(folder + "/fleet").empty());
  ASSERT_EQ(fleet("report", folder + "/fleet").exit_code, 0);
  EXPECT_EQ(report_of(folder + "/fleet")["failures"][0]["units"].size(), 2U);
}

TEST(Fleet, AFullDiskEndsTheRunWithALine) {
  const std::string folder = scratch_dir();
  ASSERT_EQ(fleet("plan", folder + "/fleet", words(small_courses(60, 3), {"--cache", folder + "/full"})).exit_code, 0);
  fs::create_directory(folder + "/full");
  const std::string script = fmt::format(
      "mount -t tmpfs -o size=240k,mode=755 tmpfs {0}/full && {1} fleet run --out {0}/fleet -j 2 --units-per-task 15",
      folder, binary("cliquevo"));
  const Finished done = run({"unshare", ::geteuid() == 0 ? "-m" : "-rm", "sh", "-c", script});
  expect_one_line(done, 1, "cannot write (No space left on device)");
  EXPECT_NE(done.err.find("make room"), std::string::npos) << done.err;
}

TEST(Fleet, WithoutSlurmALineSaysSo) {
  const std::string folder = scratch_dir() + "/fleet";
  ASSERT_EQ(fleet("plan", folder, {small_course(1)}).exit_code, 0);
  expect_one_line(fleet("run", folder, {"--on", "slurm"}, {{"PATH", "/nowhere"}}), 1, "no Slurm here");
}

TEST(Fleet, WrongInputIsOneLineEach) {
  const std::string folder = scratch_dir();
  const auto usage = [&](const std::vector<std::string>& more) { return fleet("plan", folder + "/fleet", more); };
  expect_one_line(usage({}), 2, "wrong usage");
  expect_one_line(usage({small_course(1), "--set", "stereo.windw=7"}), 1, "did you mean");
  expect_one_line(usage({small_course(1), "--set", "stereo"}), 1, "no setting");
  expect_one_line(usage({small_course(1), "--config", folder + "/none.yaml"}), 1, "none.yaml");
  expect_one_line(usage({"sim:frames=x"}), 1, "frames");
  expect_one_line(usage({folder + "/*.log"}), 1, "nothing matches");
  expect_one_line(usage({"@" + folder + "/none"}), 1, "list of recordings");
  expect_one_line(fleet("run", folder + "/never"), 1, "there is no plan");
  expect_one_line(fleet("status", folder + "/never"), 1, "there is no plan");
  expect_one_line(fleet("report", folder + "/never"), 1, "there is no plan");
  std::ofstream(folder + "/plan.json") << "{}";
  expect_one_line(fleet("status", folder), 1, "no plan of a fleet");
  expect_one_line(run({binary("cliquevo"), "fleet", "run-unit", "--units", "0"}), 2, "--plan");
}

}  // namespace
}  // namespace cliquevo::test
