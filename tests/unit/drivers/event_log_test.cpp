// SPDX-License-Identifier: BSD-3-Clause
// Whatever is left of a log plays up to its last whole pair, and says what is missing.
#include "drivers/recording/event_log.h"

#include <filesystem>
#include <fstream>
#include <sys/resource.h>
#include <sys/stat.h>

#include <gtest/gtest.h>

#include "core/base/time.h"
#include "drivers/recorder.h"
#include "drivers/recording.h"
#include "drivers/recording/calibration_message.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"
#include "tests/unit/drivers/made_up_source.h"

namespace cliquevo::drivers {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kPairs = 6;

std::string make_log() {
  const std::string path = test::scratch_dir() + "/a.lcm";
  const SourceInfo info = test::made_up_info(32, 24);
  RecorderOptions options;
  options.path = path;
  options.wait_when_full = true;
  auto recorder = Recorder::start(options, info);
  EXPECT_TRUE(recorder.ok());
  StereoPair pair;
  for (std::int64_t i = 0; i < kPairs; ++i) {
    test::make_up_pair(i, info, pair);
    recorder->add(pair, pair.stamp_ns / 1000);
  }
  EXPECT_TRUE(recorder->stop().ok());
  return path;
}

Result<std::unique_ptr<FrameSource>> open(const std::string& path) {
  RecordingOptions options;
  options.path = path;
  options.read_ahead = false;
  return open_recording(options);
}

struct Played {
  std::int64_t whole = 0;
  std::int64_t errors = 0;
};
// Plays all; no pair may be another than it was.
Played play(FrameSource& source) {
  Played played;
  StereoPair pair;
  for (std::int64_t i = 0; i < 2 * kPairs; ++i) {
    const auto more = source.next(pair);
    if (more.ok() && !*more) break;
    if (more.ok()) {
      ++played.whole;
    } else {
      ++played.errors;
    }
  }
  return played;
}

TEST(EventLog, CutAtAnyPlaceItPlaysEveryPairThatIsWhole) {
  const std::string path = make_log();
  const auto size = static_cast<std::int64_t>(fs::file_size(path));
  const std::string cut = test::scratch_dir() + "/cut.lcm";
  std::int64_t most = 0;
  for (std::int64_t length = size; length >= 0; length -= 97) {
    fs::copy_file(path, cut, fs::copy_options::overwrite_existing);
    fs::resize_file(cut, static_cast<std::uintmax_t>(length));
    const auto source = open(cut);
    if (!source.ok()) {
      EXPECT_LT(length, 28 + 8 + 700 + 2000) << source.error().line();
      continue;
    }
    const Played played = play(**source);
    EXPECT_EQ(played.errors, 0);
    EXPECT_EQ(played.whole, (*source)->info().frame_count);
    const bool reported = (*source)->info().description.find("cut off") != std::string::npos;
    if (length == size) {
      EXPECT_EQ(played.whole, kPairs);
      EXPECT_FALSE(reported);
    }
    if (most > played.whole && length < size) {
      EXPECT_TRUE(reported || played.whole < most);
    }
    most = played.whole;
  }
}

TEST(EventLog, DamageInTheMiddleCostsThatPairAloneAndIsTold) {
  const std::string path = make_log();
  std::int64_t third = 0;
  {
    const auto log = EventLogReader::open(path);
    ASSERT_TRUE(log.ok());
    int seen = 0;
    log->scan([&](std::string_view channel, const LoggedEvent& event) {
      if (channel == "VO_STEREO" && ++seen == 3) third = event.data_at - 28 - static_cast<std::int64_t>(channel.size());
    });
  }
  ASSERT_GT(third, 0);
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(third);
  file.write("junk", 4);
  file.close();
  const auto source = open(path);
  ASSERT_TRUE(source.ok()) << source.error().line();
  EXPECT_EQ(play(**source).whole, kPairs - 1);
  EXPECT_NE((*source)->info().description.find("damaged in 1 places"), std::string::npos)
      << (*source)->info().description;
}

TEST(EventLog, FlippedBytesAnywhereNeverCrashIt) {
  const std::string path = make_log();
  std::ifstream in(path, std::ios::binary);
  const std::string whole((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const std::string broken = test::scratch_dir() + "/broken.lcm";
  std::uint64_t state = 7;
  const auto random = [&state](std::size_t below) {
    state = state * 6364136223846793005U + 1442695040888963407U;
    return static_cast<std::size_t>(state >> 33U) % below;
  };
  for (int round = 0; round < 400; ++round) {
    std::string bytes = whole;
    // Half of the rounds in the beginning, where lengths and the calibration are.
    const std::size_t range = round % 2 == 0 ? 1500 : bytes.size();
    for (int i = 0; i < 4; ++i) bytes[random(range)] = static_cast<char>(random(256));
    std::ofstream(broken, std::ios::binary) << bytes;
    const auto source = open(broken);
    if (source.ok()) play(**source);
  }
}

TEST(EventLog, AFileThatIsNoLogIsRefusedInOneLine) {
  const std::string path = test::scratch_dir() + "/a.lcm";
  std::ofstream(path) << "no log at all";
  const auto source = open(path);
  ASSERT_FALSE(source.ok());
  EXPECT_NE(source.error().line().find("LCM event log"), std::string::npos) << source.error().line();
}

// Each of two million places begins like an event.
TEST(EventLog, MagicOverAndOverIsReadThroughAtOnce) {
  const std::string path = test::scratch_dir() + "/a.lcm";
  std::string bytes;
  for (int i = 0; i < 2'000'000; ++i) bytes += "\xED\xA1\xDA\x01";
  const std::string whole = test::read_file(make_log());
  std::ofstream(path, std::ios::binary) << whole << bytes << whole;
  const std::int64_t begin_ns = monotonic_ns();
  const auto log = EventLogReader::open(path);
  ASSERT_TRUE(log.ok());
  std::int64_t events = 0;
  const LogDamage damage = log->scan([&](std::string_view, const LoggedEvent&) { ++events; });
  EXPECT_LT(monotonic_ns() - begin_ns, 10'000'000'000);  // a minute before
  EXPECT_EQ(events, 2 * (kPairs + 1));
  EXPECT_EQ(damage.broken_places, 1);
  EXPECT_EQ(damage.torn_tail, 0);
}

TEST(EventLog, AMaskOfTwoGigabytesInAShortMessageIsNotBelieved) {
  const SourceInfo info = test::made_up_info(32, 24);
  const std::vector<std::uint8_t> whole = encode_calibration(info, 1'000'000);
  ASSERT_TRUE(parse_calibration_message(whole.data(), whole.size(), "a.lcm").ok());
  // The two last numbers are the sizes of the masks; here there are none.
  for (const std::size_t from_end : {std::size_t{4}, std::size_t{8}}) {
    for (const std::uint32_t size : {0x7fffffffU, 0xffffffffU, 0x80000000U, 1U}) {
      std::vector<std::uint8_t> torn = whole;
      for (std::size_t i = 0; i < 4; ++i) {
        torn[torn.size() - from_end + i] = static_cast<std::uint8_t>(size >> (24 - 8 * i));
      }
      EXPECT_FALSE(parse_calibration_message(torn.data(), torn.size(), "a.lcm").ok()) << size;
    }
  }
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  EXPECT_LT(used.ru_maxrss, 1'000'000) << "kB";
}

TEST(EventLog, WhatAnEventLogBeginsWith) {
  const std::string dir = test::scratch_dir();
  const std::string log = make_log();
  EXPECT_EQ(first_channel(log), "VO_CALIBRATION");
  EXPECT_TRUE(is_own_log(log));
  fs::create_symlink(log, dir + "/link.lcm");
  EXPECT_FALSE(is_own_log(dir + "/link.lcm"));
  std::ofstream(dir + "/text.lcm") << "a text of more than the twenty-eight bytes that an event begins with";
  EXPECT_FALSE(is_own_log(dir + "/text.lcm"));
  EXPECT_FALSE(is_own_log(dir));
  EXPECT_FALSE(is_own_log(dir + "/none.lcm"));
  ASSERT_EQ(::mkfifo((dir + "/pipe.lcm").c_str(), 0600), 0);
  EXPECT_FALSE(is_own_log(dir + "/pipe.lcm"));
}

}  // namespace
}  // namespace cliquevo::drivers
