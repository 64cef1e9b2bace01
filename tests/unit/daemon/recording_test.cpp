// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/recording.h"

#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <sys/stat.h>
#include <unistd.h>

#include <gtest/gtest.h>

#include "daemon/log_names.h"
#include "tests/support/test_data.h"
#include "tests/unit/drivers/made_up_source.h"

namespace cliquevo::daemon {
namespace {

namespace fs = std::filesystem;

TEST(LogNames, AreThoseThatTheDaemonGivesAndNoOthers) {
  const auto first = parse_log_name("cliquevo-20231114T221320Z-000.lcm");
  ASSERT_TRUE(first);
  EXPECT_EQ(first->start_s, 1'700'000'000);
  EXPECT_EQ(first->run, 1);
  const auto later = parse_log_name("cliquevo-20231114T221320Z.012-1003.lcm");
  ASSERT_TRUE(later);
  EXPECT_EQ(later->run, 12);
  EXPECT_EQ(later->part, 1003);
  EXPECT_EQ(log_name(1'700'000'000, 1), "cliquevo-20231114T221320Z.lcm");
  EXPECT_EQ(log_name(1'700'000'000, 2), "cliquevo-20231114T221320Z.002.lcm");
  for (const char* name :
       {"cliquevo-notes.lcm", "cliquevo-20231114T221320Z.lcm", "cliquevo-20231114T221320Z-0.lcm", "cliquevo-.lcm",
        "cliquevo-20231114T221320Z-000.lcm.bak", "xcliquevo-20231114T221320Z-000.lcm", "cliquevo-20231114T221320Z-000",
        "cliquevo-20231114T221320Z.-000.lcm", "cliquevo-20231114T2213Z-000.lcm", "",
        "cliquevo-20231114T221320Z-00000000000000000000.lcm"}) {
    EXPECT_FALSE(parse_log_name(name)) << name;
  }
}

class DaemonRecording : public testing::Test {
 protected:
  DaemonRecording() { config_.folder = folder_; }
  void record_some(Recording& recording, std::int64_t from = 0) const {
    drivers::StereoPair pair;
    for (std::int64_t i = from; i < from + 5; ++i) {
      test::make_up_pair(i, info_, pair);
      recording.add(pair);
    }
  }
  std::vector<std::string> files() const {
    std::vector<std::string> out;
    for (const auto& entry : fs::directory_iterator(folder_)) out.push_back(entry.path().filename().string());
    std::sort(out.begin(), out.end());
    return out;
  }
  const std::string folder_ = test::scratch_dir() + "/logs";
  drivers::SourceInfo info_ = test::made_up_info();
  RecordingConfig config_;
};

TEST_F(DaemonRecording, ManyInOneSecondHaveNamesOfTheirOwn) {
  for (int i = 0; i < 12; ++i) {
    Recording recording(config_, info_, true);
    ASSERT_TRUE(recording.start().ok());
    EXPECT_TRUE(recording.start().ok()) << "while one is written nothing happens";
    record_some(recording);
    ASSERT_TRUE(recording.stop().ok());
  }
  EXPECT_EQ(files().size(), 12U);
  EXPECT_EQ(own_logs(folder_).size(), 12U);
  struct stat status = {};
  ASSERT_EQ(::stat((folder_ + "/" + files()[0]).c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 07U, 0U);
}

TEST_F(DaemonRecording, WhatCannotStartIsToldUntilItCan) {
  std::ofstream(folder_) << "a file in the way";
  Recording recording(config_, info_, true);
  EXPECT_EQ(recording.status(), "");
  ASSERT_FALSE(recording.start().ok());
  EXPECT_EQ(recording.status().rfind("recording failed: cannot record: " + folder_, 0), 0U) << recording.status();
  EXPECT_FALSE(recording.active());
  record_some(recording);
  fs::remove(folder_);
  ASSERT_TRUE(recording.start().ok());
  EXPECT_EQ(recording.status().rfind("recording, ", 0), 0U) << recording.status();
  ASSERT_TRUE(recording.stop().ok());
  EXPECT_EQ(recording.status(), "");
}

TEST_F(DaemonRecording, OldestOfItsOwnIsTheOneThatBeganOrWasWrittenFirst) {
  Recording recording(config_, info_, true);
  ASSERT_TRUE(recording.start().ok());
  record_some(recording);
  ASSERT_TRUE(recording.stop().ok());
  const fs::path one = fs::path(folder_) / files()[0];
  const auto copy = [&](const char* name) { fs::copy_file(one, fs::path(folder_) / name); };
  copy("cliquevo-20220101T000000Z-001.lcm");
  copy("cliquevo-20220101T000000Z-000.lcm");
  copy("cliquevo-20220101T000000Z.002-000.lcm");
  copy("cliquevo-20210101T000000Z-000.lcm");
  copy("cliquevo-20230101T000000Z-000.lcm");
  copy("cliquevo-old-copy.lcm");
  const timespec long_ago[2] = {{1'000'000'000, 0}, {1'000'000'000, 0}};
  ASSERT_EQ(::utimensat(AT_FDCWD, (folder_ + "/cliquevo-20230101T000000Z-000.lcm").c_str(), long_ago, 0), 0);
  std::ofstream(folder_ + "/cliquevo-20200101T000000Z-000.lcm") << "named so, but no log";
  fs::create_symlink(one, folder_ + "/cliquevo-20190101T000000Z-000.lcm");
  fs::create_directory(folder_ + "/cliquevo-20180101T000000Z-000.lcm");
  std::vector<std::string> expected{"cliquevo-20230101T000000Z-000.lcm",     "cliquevo-20210101T000000Z-000.lcm",
                                    "cliquevo-20220101T000000Z-000.lcm",     "cliquevo-20220101T000000Z-001.lcm",
                                    "cliquevo-20220101T000000Z.002-000.lcm", one.filename().string()};
  std::vector<std::string> found;
  for (const std::string& path : own_logs(folder_)) found.push_back(fs::path(path).filename().string());
  EXPECT_EQ(found, expected);
}

}  // namespace
}  // namespace cliquevo::daemon
