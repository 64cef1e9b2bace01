// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/recorder.h"

#include <bot_core/images_t.hpp>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <gtest/gtest.h>
#include <lcm/lcm-cpp.hpp>

#include "drivers/recording.h"
#include "tests/support/test_data.h"
#include "tests/unit/drivers/made_up_source.h"

namespace cliquevo::drivers {
namespace {

namespace fs = std::filesystem;

RecorderOptions into(const std::string& path) {
  RecorderOptions options;
  options.path = path;
  options.wait_when_full = true;
  return options;
}

void record(const RecorderOptions& options, const SourceInfo& info, std::int64_t first, std::int64_t count) {
  auto recorder = Recorder::start(options, info);
  ASSERT_TRUE(recorder.ok()) << recorder.error().line();
  StereoPair pair;
  for (std::int64_t i = first; i < first + count; ++i) {
    test::make_up_pair(i, info, pair);
    EXPECT_TRUE(recorder->add(pair, log_utime(info, pair)));
  }
  EXPECT_TRUE(recorder->stop().ok());
  EXPECT_EQ(recorder->counts().pairs, count);
  EXPECT_EQ(recorder->counts().left_out, 0);
}

std::unique_ptr<FrameSource> open(const std::string& path) {
  RecordingOptions options;
  options.path = path;
  auto source = open_recording(options);
  EXPECT_TRUE(source.ok()) << source.error().line();
  return source ? std::move(*source) : nullptr;
}

// How many pairs it plays; each must be whole and follow the one before.
std::int64_t count_whole_pairs(FrameSource& source, std::int64_t first = 0) {
  StereoPair pair;
  std::int64_t count = 0;
  for (;; ++count) {
    const auto more = source.next(pair);
    EXPECT_TRUE(more.ok()) << more.error().line();
    if (!more.ok() || !*more) return count;
    StereoPair wanted;
    test::make_up_pair(first + count, source.info(), wanted);
    EXPECT_EQ(pair.stamp_ns, wanted.stamp_ns);
    EXPECT_EQ(test::shown_pair(pair, first + count + 1), first + count);
  }
}

TEST(Recorder, ALogGivesBackEveryBitOfPairsAndCalibration) {
  const std::string path = test::scratch_dir() + "/a.lcm";
  SourceInfo info = test::made_up_info();
  info.left_mask.resize(info.width, info.height);
  info.left_mask.fill(255);
  info.left_mask.view()(3, 4) = 0;
  record(into(path), info, 0, 20);
  const auto source = open(path);
  ASSERT_NE(source, nullptr);
  const SourceInfo& got = source->info();
  EXPECT_EQ(got.frame_count, 20);
  EXPECT_NEAR(got.rate_hz, 30.0, 1e-6);
  const auto same = [](const CameraCalibration& a, const CameraCalibration& b) {
    return a.width == b.width && a.height == b.height && a.fx_px == b.fx_px && a.fy_px == b.fy_px &&
           a.cx_px == b.cx_px && a.cy_px == b.cy_px && a.distortion == b.distortion && a.coefficients == b.coefficients;
  };
  EXPECT_TRUE(same(got.calibration.left, info.calibration.left));
  EXPECT_TRUE(same(got.calibration.right, info.calibration.right));
  EXPECT_EQ(got.calibration.T_right_left.R, info.calibration.T_right_left.R);
  EXPECT_EQ(got.calibration.T_right_left.t, info.calibration.T_right_left.t);
  EXPECT_FALSE(got.calibration.rectified || got.calibration.prescribed);
  EXPECT_EQ(got.calibration.source, info.calibration.source);
  ASSERT_FALSE(got.left_mask.empty());
  EXPECT_EQ(got.left_mask.cview()(3, 4), 0);
  EXPECT_EQ(got.left_mask.cview()(4, 3), 255);
  EXPECT_TRUE(got.right_mask.empty());
  StereoPair pair;
  ASSERT_TRUE(source->next(pair).ok());
  EXPECT_EQ(pair.right_offset_ns, 1234);
  EXPECT_EQ(pair.host_ns, pair.stamp_ns + 5'000'017);
  EXPECT_EQ(count_whole_pairs(*open(path)), 20);
}

TEST(Recorder, APrescribedRectificationIsKept) {
  const std::string path = test::scratch_dir() + "/a.lcm";
  SourceInfo info = test::made_up_info();
  StereoCalibration& c = info.calibration;
  c.T_right_left = {};
  c.T_right_left.t = {-0.25, 0.0, 0.0};
  c.rectified = true;
  c.prescribed = PrescribedRectification{};
  c.prescribed->model = {info.width, info.height, 61.3, 60.9, 31.1, 24.7, 0.25, 0.125};
  record(into(path), info, 0, 1);
  const auto source = open(path);
  ASSERT_NE(source, nullptr);
  ASSERT_TRUE(source->info().calibration.prescribed);
  EXPECT_TRUE(source->info().calibration.rectified);
  const StereoModel& model = source->info().calibration.prescribed->model;
  EXPECT_EQ(model.fx_px, 61.3);
  EXPECT_EQ(model.fy_px, 60.9);
  EXPECT_EQ(model.baseline_m, 0.25);
  EXPECT_EQ(model.doffs_px, 0.125);
}

TEST(Recorder, ItsPairsDecodeWithBotCoresTypeAndLcmsReader) {
  const std::string path = test::scratch_dir() + "/a.lcm";
  const SourceInfo info = test::made_up_info();
  record(into(path), info, 0, 3);
  lcm::LogFile log(path, "r");
  ASSERT_TRUE(log.good());
  std::int64_t pairs = 0;
  std::int64_t calibrations = 0;
  for (const lcm::LogEvent* event = log.readNextEvent(); event != nullptr; event = log.readNextEvent()) {
    if (event->channel == "VO_CALIBRATION") ++calibrations;
    if (event->channel != "VO_STEREO") continue;
    bot_core::images_t images;
    ASSERT_EQ(images.decode(event->data, 0, event->datalen), event->datalen);
    StereoPair pair;
    test::make_up_pair(pairs++, info, pair);
    EXPECT_EQ(images.utime, pair.stamp_ns / 1000);
    EXPECT_EQ(event->timestamp, images.utime);
    ASSERT_EQ(images.n_images, 2);
    EXPECT_EQ(images.image_types, (std::vector<std::int16_t>{0, 1}));
    EXPECT_EQ(images.images[0].pixelformat, 1497715271);
    EXPECT_EQ(images.images[1].width, info.width);
    EXPECT_EQ(images.images[1].data[5], pair.right.cview()(5, 0));
    EXPECT_EQ(images.images[0].metadata[0].key, "stamp_ns");
  }
  EXPECT_EQ(pairs, 3);
  EXPECT_EQ(calibrations, 1);
}

TEST(Recorder, FilesRotateAndTheOldestGo) {
  const std::string dir = test::scratch_dir();
  const SourceInfo info = test::made_up_info();
  RecorderOptions options = into(dir + "/run.lcm");
  options.max_file_bytes = 40'000;    // six pairs of 6144 bytes
  options.max_total_bytes = 130'000;  // three files
  record(options, info, 0, 60);
  std::int64_t files = 0;
  std::uintmax_t bytes = 0;
  for (const auto& entry : fs::directory_iterator(dir)) {
    ++files;
    bytes += entry.file_size();
    EXPECT_LE(entry.file_size(), 40'000U) << entry.path();
    EXPECT_GE(count_whole_pairs(*open(entry.path().string()), 6 * std::stoll(entry.path().stem().string().substr(4))),
              5)
        << "each file can be played alone";
  }
  EXPECT_EQ(files, 3);
  EXPECT_LE(bytes, 130'000U);
  const auto all = open(dir);
  ASSERT_NE(all, nullptr);
  const std::int64_t kept = all->info().frame_count;
  EXPECT_EQ(count_whole_pairs(*all, 60 - kept), kept);
}

TEST(Recorder, LogsOfEarlierRunsCountToo) {
  const std::string dir = test::scratch_dir();
  const SourceInfo info = test::made_up_info();
  record(into(dir + "/old.lcm"), info, 0, 10);
  RecorderOptions options = into(dir + "/new.lcm");
  options.max_file_bytes = 40'000;
  options.max_total_bytes = 80'000;
  options.older_files = {dir + "/old.lcm"};
  record(options, info, 0, 2);
  EXPECT_FALSE(fs::exists(dir + "/old.lcm"));
  EXPECT_TRUE(fs::exists(dir + "/new-000.lcm"));
}

TEST(Recorder, WhatFindsTheQueueFullIsCountedNotWaitedFor) {
  const SourceInfo info = test::made_up_info(640, 480);
  RecorderOptions options;
  options.path = test::scratch_dir() + "/a.lcm";
  options.max_queue_bytes = 1'000'000;  // one pair, and nothing beside it
  auto recorder = Recorder::start(options, info);
  ASSERT_TRUE(recorder.ok());
  StereoPair pair;
  test::make_up_pair(0, info, pair);
  std::int64_t taken = 0;
  for (int i = 0; i < 200; ++i) {
    pair.stamp_ns += 33'333'333;
    taken += recorder->add(pair, pair.stamp_ns / 1000) ? 1 : 0;
  }
  EXPECT_TRUE(recorder->stop().ok());
  const RecorderCounts counts = recorder->counts();
  EXPECT_GE(taken, 1);
  EXPECT_EQ(counts.pairs, taken);
  EXPECT_EQ(counts.pairs + counts.left_out, 200);
  EXPECT_EQ(open(options.path)->info().frame_count, taken);
}

TEST(Recorder, AFileThatMayNotGrowEndsItWithOneLineAndStaysReadable) {
  const std::string path = test::scratch_dir() + "/a.lcm";
  const SourceInfo info = test::made_up_info();
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);  // the write fails instead, as on a full disk
    const rlimit limit{50'000, 50'000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    auto recorder = Recorder::start(into(path), info);
    if (!recorder.ok()) ::_exit(2);
    StereoPair pair;
    for (std::int64_t i = 0; i < 30; ++i) {
      test::make_up_pair(i, info, pair);
      recorder->add(pair, log_utime(info, pair));
    }
    const auto stopped = recorder->stop();
    const RecorderCounts counts = recorder->counts();
    const bool counted = counts.pairs + counts.left_out == 30 && counts.pairs == 7;
    ::_exit(!stopped.ok() && counted && stopped.error().line().find("a.lcm") != std::string::npos ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  const auto source = open(path);
  ASSERT_NE(source, nullptr);
  EXPECT_EQ(source->info().description.find("cut off"), std::string::npos) << "nothing torn is left behind";
  EXPECT_EQ(count_whole_pairs(*source), 7);
}

TEST(Recorder, RefusesAFileThatIsThereAndAFolderThatIsNot) {
  const std::string dir = test::scratch_dir();
  const SourceInfo info = test::made_up_info();
  record(into(dir + "/a.lcm"), info, 0, 1);
  const auto twice = Recorder::start(into(dir + "/a.lcm"), info);
  ASSERT_FALSE(twice.ok());
  EXPECT_NE(twice.error().line().find("there already"), std::string::npos);
  EXPECT_FALSE(Recorder::start(into(dir + "/no/such/folder/a.lcm"), info).ok());
}

}  // namespace
}  // namespace cliquevo::drivers
