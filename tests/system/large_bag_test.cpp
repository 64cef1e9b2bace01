// SPDX-License-Identifier: BSD-3-Clause
// Bags of 2 GB by others' writers: little memory, the middle at once, and torn ones up to their last whole message.
#include <chrono>
#include <cstdint>
#include <fcntl.h>
#include <filesystem>
#include <string>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "drivers/recording.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"
#include "tests/system/made_recording.h"
#include "tests/system/peers.h"

namespace cliquevo::test {
namespace {

namespace fs = std::filesystem;

constexpr int kPairs = 12;
constexpr int kTimes = 1200;  // of 320 x 240: 2.2 GB
constexpr std::int64_t kAll = std::int64_t{kPairs} * kTimes;
constexpr std::uintmax_t kLeastBytes = 2'000'000'000;  // what is in compressed ones is as much, but not the file
constexpr double kMostSeek_s = 1.0;
constexpr long kMostMemory_kb = 300'000;

// Removed with the test: scratch folders stay.
class LargeBag {
 public:
  LargeBag(const std::string& name, const std::string& compression) : path_(scratch_dir() + "/" + name) {
    fs::remove(path_);
    const std::string folder = made_recording(kPairs);
    const std::string times = std::to_string(kTimes);
    if (path_.ends_with(".mcap")) {
      const std::string lines = scratch_dir() + "/messages.jsonl";
      run_peer("write_bag.py", {folder, lines});
      run_peer("write_mcap.mjs", {lines, path_, compression, times});
    } else {
      run_peer("write_bag.py", {folder, path_, compression, times});
    }
  }
  ~LargeBag() { fs::remove(path_); }
  LargeBag(const LargeBag&) = delete;
  LargeBag& operator=(const LargeBag&) = delete;
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

// What of it the system keeps in memory goes, so that the disk is read.
void drop_cached(const std::string& path) {
  const int file = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  ::fsync(file);
  EXPECT_EQ(::posix_fadvise(file, 0, 0, POSIX_FADV_DONTNEED), 0);
  ::close(file);
}

double seconds_since(std::chrono::steady_clock::time_point start) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

struct Seek {
  double open_s = 0.0;
  double seek_s = 0.0;  // from open to a pair of the middle
};
Seek seek_middle(const std::string& path) {
  Seek out;
  drivers::RecordingOptions options;
  options.path = path;
  options.first = kAll / 2;
  const auto start = std::chrono::steady_clock::now();
  auto source = drivers::open_recording(options);
  EXPECT_TRUE(source.ok()) << source.error().line();
  if (!source) return out;
  out.open_s = seconds_since(start);
  EXPECT_EQ((*source)->info().frame_count, kAll - kAll / 2);
  const auto opened = std::chrono::steady_clock::now();
  drivers::StereoPair pair;
  const auto more = (*source)->next(pair);
  out.seek_s = seconds_since(opened);
  EXPECT_TRUE(more.ok() && *more);
  EXPECT_EQ(pair.index, kAll / 2);
  return out;
}

// Exit code and largest resident memory of a program.
struct Measured {
  int exit_code = -1;
  long memory_kb = 0;
  double seconds = 0.0;
};
Measured measure(const std::vector<std::string>& command) {
  const auto start = std::chrono::steady_clock::now();
  const pid_t child = ::fork();
  if (child == 0) {
    ::dup2(::open("/dev/null", O_WRONLY | O_CLOEXEC), STDOUT_FILENO);
    std::vector<char*> arguments;
    for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    ::execv(arguments[0], arguments.data());
    ::_exit(127);
  }
  Measured out;
  int status = 0;
  rusage used{};
  ::wait4(child, &status, 0, &used);
  out.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  out.memory_kb = used.ru_maxrss;
  out.seconds = seconds_since(start);
  return out;
}

void expect_quick_and_small(const std::string& path, std::uintmax_t least_bytes = kLeastBytes) {
  ASSERT_GE(fs::file_size(path), least_bytes);
  drop_cached(path);
  const Seek cold = seek_middle(path);
  const Seek warm = seek_middle(path);
  fmt::print("{}: {:.2f} GB; opened in {:.2f} s (again {:.2f} s), the middle {:.3f} s after (again {:.3f} s)\n",
             fs::path(path).filename().string(), static_cast<double>(fs::file_size(path)) * 1e-9, cold.open_s,
             warm.open_s, cold.seek_s, warm.seek_s);
  EXPECT_LT(cold.seek_s, kMostSeek_s);
  EXPECT_LT(warm.seek_s, kMostSeek_s);
  const std::string middle = std::to_string(kAll / 2);
  const Measured part = measure({binary("cliquevo"), "replay", path, "--first", middle, "--last",
                                 std::to_string(kAll / 2 + 9), "--trajectory", scratch_dir() + "/t.txt"});
  EXPECT_EQ(part.exit_code, 0);
  EXPECT_LT(part.memory_kb, kMostMemory_kb);
  // All of it, without the odometry.
  const Measured all = measure({binary("cliquevo"), "info", path});
  EXPECT_EQ(all.exit_code, 0);
  EXPECT_LT(all.memory_kb, kMostMemory_kb);
  fmt::print("  ten pairs of the middle replayed: {:.2f} s, {} MB; info: {:.2f} s, {} MB\n", part.seconds,
             part.memory_kb / 1000, all.seconds, all.memory_kb / 1000);
}

// Cut within a message: everything before it plays.
void expect_plays_when_torn(const std::string& path) {
  fs::resize_file(path, fs::file_size(path) * 9 / 10 + 12'345);
  drivers::RecordingOptions options;
  options.path = path;
  auto source = drivers::open_recording(options);
  ASSERT_TRUE(source.ok()) << source.error().line();
  const std::int64_t there = (*source)->info().frame_count;
  EXPECT_NEAR(static_cast<double>(there), 0.9 * static_cast<double>(kAll), 60.0);
  options.first = there - 1;
  source = drivers::open_recording(options);
  ASSERT_TRUE(source.ok()) << source.error().line();
  drivers::StereoPair pair;
  const auto last = (*source)->next(pair);
  EXPECT_TRUE(last.ok() && *last);
  EXPECT_EQ(pair.index, there - 1);
  fmt::print("  torn: {} of {} pairs, the last one whole\n", there, kAll);
}

TEST(LargeBags, AnMcap) {
  const LargeBag bag("large.mcap", "none");
  expect_quick_and_small(bag.path());
  expect_plays_when_torn(bag.path());
}

TEST(LargeBags, AnMcapOfCompressedChunks) {
  const LargeBag bag("large_zstd.mcap", "zstd");
  expect_quick_and_small(bag.path(), kLeastBytes / 2);
  expect_plays_when_torn(bag.path());
}

TEST(LargeBags, ABagOfRos1) {
  const LargeBag bag("large.bag", "none");
  expect_quick_and_small(bag.path());
  expect_plays_when_torn(bag.path());
}

TEST(LargeBags, ADatabaseOfRosbag2) {
  const LargeBag bag("large.db3", "none");
  expect_quick_and_small(bag.path());
}

}  // namespace
}  // namespace cliquevo::test
