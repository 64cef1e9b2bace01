// SPDX-License-Identifier: BSD-3-Clause
// What the machine itself does to a daemon: full and missing disks, a clock that begins anew at each boot, stderr that
// takes nothing, configurations that were made to hurt. The odometry goes on.
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sys/mount.h>
#include <sys/stat.h>
#include <thread>
#include <unistd.h>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/hil/attacked_daemon.h"
#include "tests/hil/private_network.h"
#include "tests/support/test_data.h"

namespace cliquevo::test {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> files_in(const std::string& folder) {
  std::vector<fs::path> out;
  std::error_code none;
  for (const auto& entry : fs::directory_iterator(folder, none)) out.push_back(entry.path());
  std::sort(out.begin(), out.end());
  return out;
}

bool recording(const nlohmann::json& status) { return status.value("recording_text", "").starts_with("recording, "); }
bool failed(const nlohmann::json& status) { return status.value("recording_text", "").starts_with("recording failed"); }

TEST(RecordingTrouble, AFolderThatCannotBeIsToldAndTheOdometryGoesOn) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  const std::string dir = scratch_dir();
  std::ofstream(dir + "/file") << "in the way";
  AttackedDaemon daemon("recording: {folder: " + dir + "/file/logs, at_start: true}\n");
  ASSERT_TRUE(daemon.ok());
  EXPECT_TRUE(failed(daemon.status())) << daemon.status().dump();
  const Finished refused = daemon.ctl("record-start");
  EXPECT_EQ(refused.exit_code, 1);
  EXPECT_NE(refused.err.find("cannot record"), std::string::npos) << refused.err;
  fs::remove(dir + "/file");
  EXPECT_EQ(daemon.ctl("record-start").exit_code, 0);
  EXPECT_TRUE(recording(daemon.status_once(recording)));
  daemon.expect_unharmed();
  daemon.finish();
  EXPECT_EQ(files_in(dir + "/file/logs").size(), 1U);
}

TEST(RecordingTrouble, AfterAFullDiskStartBeginsAnew) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  const std::string disk = scratch_dir();
  if (::mount("none", disk.c_str(), "tmpfs", 0, "size=1m") != 0) GTEST_SKIP() << "needs the right to mount";
  AttackedDaemon daemon("recording: {folder: " + disk + ", at_start: true, max_file_mb: 100, max_total_mb: 1000}\n");
  EXPECT_TRUE(daemon.ok());
  const auto full = daemon.status_once(failed);
  EXPECT_TRUE(failed(full)) << full.dump();
  EXPECT_NE(full.value("recording_text", "").find("No space left"), std::string::npos) << full.dump();
  daemon.expect_unharmed();
  for (const fs::path& file : files_in(disk)) fs::remove(file);
  // Room for longer than the status takes to show it.
  ASSERT_EQ(::mount("none", disk.c_str(), nullptr, MS_REMOUNT, "size=500m"), 0);
  EXPECT_EQ(daemon.ctl("record-start").exit_code, 0);
  EXPECT_TRUE(recording(daemon.status_once(recording)));
  daemon.finish();
  EXPECT_EQ(files_in(disk).size(), 1U);
  ::umount2(disk.c_str(), MNT_DETACH);
}

TEST(RecordingTrouble, FiftyBootsWithOneClockLeaveFiftyRecordings) {
  const std::string dir = scratch_dir();
  std::ofstream(dir + "/c.yaml")
      << "source:\n  speed: 0\n  simulator: {width: 160, height: 120, focal_px: 175, frames: 2, "
         "course: standing, cache_dir: " +
             dir +
             "/cache}\nstereo: {num_disparities: 48}\n"
             "control: {socket: \"\"}\nlcm: {url: \"memq://\"}\n"
             "recording: {folder: logs, at_start: true}\n";
  for (int boot = 0; boot < 50; ++boot) {
    const Finished end = run({binary("cliquevod"), "--config", dir + "/c.yaml"},
                             {{"LD_PRELOAD", CLIQUEVO_FROZEN_CLOCK}, {"CLIQUEVO_CACHE", dir + "/cache"}});
    ASSERT_EQ(end.exit_code, 0) << "boot " << boot << ": " << end.err;
  }
  const auto logs = files_in(dir + "/logs");
  EXPECT_EQ(logs.size(), 50U);
  struct stat status = {};
  for (const fs::path& log : logs) {
    ASSERT_EQ(::stat(log.c_str(), &status), 0);
    EXPECT_EQ(status.st_mode & 0777U & ~0640U, 0U) << "not readable by everybody";
    EXPECT_GT(status.st_size, 1000) << log;
  }
}

TEST(RecordingTrouble, RotationRemovesItsOwnLogsAloneTheOldestFirst) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  const std::string dir = scratch_dir();
  const std::string logs = dir + "/logs";
  fs::create_directories(logs);
  // Recordings of ours from before.
  ASSERT_EQ(run({binary("cliquevo"), "record", "sim:width=160,height=120,focal_px=175,frames=30,cache_dir=none",
                 "--out", dir + "/old.lcm"})
                .exit_code,
            0);
  fs::copy_file(dir + "/old.lcm", logs + "/cliquevo-20200101T000000Z-000.lcm");
  fs::copy_file(dir + "/old.lcm", logs + "/cliquevo-20210101T000000Z-000.lcm");
  // Somebody else's, and some that only look like ours.
  const std::vector<std::string> foreign{"cliquevo-notes.lcm", "cliquevo-20190101T000000Z-000.lcm", "holiday.lcm",
                                         "cliquevo-20190101T000000Z-000.lcm.bak", "cliquevo-19990101T000000Z-001.lcm"};
  for (const std::string& name : foreign) std::ofstream(logs + "/" + name) << std::string(100'000, 'x');
  fs::copy_file(dir + "/old.lcm", logs + "/cliquevo-archive.lcm");
  fs::create_symlink(dir + "/old.lcm", logs + "/cliquevo-20180101T000000Z-000.lcm");
  AttackedDaemon daemon("recording: {folder: " + logs + ", at_start: true, max_file_mb: 1, max_total_mb: 4}\n");
  ASSERT_TRUE(daemon.ok());
  // 38400 bytes a pair: 26 of them fill a file.
  daemon.status_once([](const auto& s) { return s.value("poses_sent", 0) > 200; });
  daemon.finish();
  for (const std::string& name : foreign) EXPECT_TRUE(fs::exists(logs + "/" + name)) << name;
  EXPECT_TRUE(fs::exists(logs + "/cliquevo-archive.lcm"));
  EXPECT_TRUE(fs::is_symlink(logs + "/cliquevo-20180101T000000Z-000.lcm"));
  EXPECT_FALSE(fs::exists(logs + "/cliquevo-20200101T000000Z-000.lcm"));
  EXPECT_FALSE(fs::exists(logs + "/cliquevo-20210101T000000Z-000.lcm"));
}

std::string quick_course(const std::string& dir) {
  std::ofstream(dir + "/c.yaml") << "source: {speed: 0, simulator: {width: 160, height: 120, focal_px: 175, frames: 4, "
                                    "cache_dir: none}}\nstereo: {num_disparities: 48}\ncontrol: {socket: \"\"}\n"
                                    "lcm: {url: \"memq://\"}\nlog: {level: trace}\n";
  return dir + "/c.yaml";
}

Finished in_shell(const std::string& command) { return run({"sh", "-c", command}); }

TEST(StandardStreams, AStderrThatIsFullOrClosedEndsNothing) {
  const std::string dir = scratch_dir();
  const std::string config = quick_course(dir);
  for (const char* where : {"2>/dev/full", "2>&-", ">&- 2>&-", "<&- >&- 2>&-"}) {
    const std::string daemon = binary("cliquevod") + " --config " + config + " --trajectory " + dir + "/t.txt " + where;
    EXPECT_EQ(in_shell(daemon).exit_code, 0) << where;
    EXPECT_EQ(lines_of(read_file(dir + "/t.txt")).size(), 4U) << "none of its lines went there: " << where;
    EXPECT_EQ(in_shell(binary("cliquevod") + " --config /nowhere " + where).exit_code, 1) << where;
    EXPECT_EQ(in_shell(binary("cliquevod") + " --nonsense " + where).exit_code, 2) << where;
    EXPECT_EQ(in_shell(binary("cliquevo") + " replay /nowhere " + where).exit_code, 1) << where;
  }
}

// The unit starts it again after every code but 1 and 2.
TEST(MemoryTrouble, EndsAServiceWithACodeThatRestartsItAndAStartByHandWithOne) {
  const std::string dir = scratch_dir();
  std::ofstream(dir + "/c.yaml") << "source: {simulator: {width: 2000, height: 1500, focal_px: 2000, frames: 2, "
                                    "cache_dir: none}}\nrealtime: {lock_memory: false}\nrectify: {scale: 1}\n"
                                    "control: {socket: \"\"}\nlcm: {url: \"memq://\"}\n";
  const std::vector<std::string> short_of_memory{
      "sh", "-c", "ulimit -v 122880; exec " + binary("cliquevod") + " --config " + dir + "/c.yaml"};
  const Finished by_hand = run(short_of_memory);
  EXPECT_EQ(by_hand.exit_code, 1) << by_hand.err;
  EXPECT_NE(by_hand.err.find("cannot go on"), std::string::npos) << by_hand.err;
  const Finished service = run(short_of_memory, {{"NOTIFY_SOCKET", dir + "/notify"}});
  EXPECT_EQ(service.exit_code, 75) << service.err;
}

TEST(StandardStreams, AStdoutThatCannotBeWrittenIsExitCodeOne) {
  const std::string dir = scratch_dir();
  const std::string config = quick_course(dir);
  std::ofstream(dir + "/poses.txt") << "1 0 0 0 0 1 0 0 0 0 1 0\n1 0 0 0 0 1 0 0 0 0 1 1\n";
  const std::string sim = "sim:width=160,height=120,focal_px=175,frames=3,cache_dir=none";
  const std::vector<std::string> commands{
      binary("cliquevod") + " --version",
      binary("cliquevod") + " --help",
      binary("cliquevod") + " --check --config " + config,
      binary("cliquevo") + " --version",
      binary("cliquevo") + " --help",
      binary("cliquevo") + " replay --help",
      binary("cliquevo") + " replay " + sim,
      binary("cliquevo") + " eval --reference " + dir + "/poses.txt --estimate " + dir + "/poses.txt",
      binary("cliquevo") + " doctor",
      binary("cliquevo") + " simulate --frames 2 --width 160 --height 120 --focal-px 175 --out " + dir + "/s$$",
      binary("cliquevo") + " record " + sim + " --out " + dir + "/r$$.lcm",
  };
  for (const std::string& command : commands) {
    for (const char* where : {" >/dev/full", " >&-"}) {
      const Finished end = in_shell(command + where);
      EXPECT_EQ(end.exit_code, 1) << command << where << "\n" << end.err;
      EXPECT_NE(end.err.find("standard output"), std::string::npos) << command << where << "\n" << end.err;
    }
  }
}

TEST(HostileConfiguration, IsRefusedAtOnceInOneLine) {
  const std::string dir = scratch_dir();
  std::string aliases = "a: &a0 [x, x, x, x, x, x, x, x, x]\n";
  for (int i = 1; i < 40; ++i) {
    aliases += fmt::format("b{0}: &a{0} [*a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}, *a{1}]\n", i, i - 1);
  }
  std::string large = "stereo: {window: 9}\n";
  large.resize(100'000'000, '#');
  const std::string huge_line = "stereo: {window: " + std::string(200'000, '9') + "}\n";
  const std::string escape = "ster\x1b[31meo\x1b]0;title\x07: {window: 9}\n";
  const std::vector<std::string> texts{aliases,
                                       large,
                                       huge_line,
                                       escape,
                                       std::string(200'000, '['),
                                       std::string(100'000, '{') + "a",
                                       "? " + std::string(100'000, '?'),
                                       "lcm: {url: \"udpm://\\e[31m\\nnext line\"}\n"};
  for (const std::string& text : texts) {
    std::ofstream(dir + "/c.yaml") << text;
    const auto begin = std::chrono::steady_clock::now();
    const Finished end = run({binary("cliquevod"), "--config", dir + "/c.yaml"});
    EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(), 5.0)
        << text.substr(0, 40);
    EXPECT_EQ(end.exit_code, 1) << text.substr(0, 40) << end.err;
    EXPECT_EQ(lines_of(end.err).size(), 1U) << end.err.substr(0, 400);
    EXPECT_EQ(end.err.find('\x1b'), std::string::npos);
    EXPECT_EQ(end.err.find('\x07'), std::string::npos);
  }
}

TEST(HostileConfiguration, ReadAgainWhileThreadsLogHarmsNobody) {
  CLIQUEVO_NEEDS_PRIVATE_NETWORK();
  AttackedDaemon daemon(std::string("lcm: {command_channel: VO_COMMAND}\n"));
  ASSERT_TRUE(daemon.ok());
  const std::string bad = short_message("VO_COMMAND", command_payload(1, 0));
  for (int i = 0; i < 200; ++i) {
    daemon.configure(std::string("lcm: {command_channel: VO_COMMAND}\nlog: {level: ") +
                     (i % 2 == 0 ? "trace" : "error") + "}\n");
    daemon.process().send(SIGHUP);
    send_datagram("239.255.76.67", 7667, bad);
    static_cast<void>(::usleep(5000));
  }
  std::ofstream(daemon.folder() + "/config.yaml") << "lcm: [&a *a\n";
  daemon.process().send(SIGHUP);
  fs::remove(daemon.folder() + "/config.yaml");
  daemon.process().send(SIGHUP);
  daemon.expect_unharmed();
  daemon.finish();
}

}  // namespace
}  // namespace cliquevo::test
