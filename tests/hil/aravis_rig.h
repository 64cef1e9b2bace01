// SPDX-License-Identifier: BSD-3-Clause
// A rendered course, `cliquevo hil` that serves it as two GigE Vision cameras, and what takes and judges their pairs.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "drivers/aravis.h"
#include "drivers/recording.h"
#include "tests/hil/private_network.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo::hil {

using drivers::StereoPair;
using std::chrono::steady_clock;

inline constexpr int kFrames = 30;

inline bool enter_network_with_two_addresses() {
  return test::enter_private_network() &&
         std::system("for i in 2 3 4; do ip address add 127.0.0.$i/8 dev lo; done") == 0;
}

inline std::uint64_t hash_of(ImageView<const std::uint8_t> image) {
  std::uint64_t hash = 1469598103934665603U;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) hash = (hash ^ image(x, y)) * 1099511628211U;
  }
  return hash;
}

// A rendered course on disk, and what its images are known by.
class Course {
 public:
  Course() : folder(test::scratch_dir() + "/course") {
    const test::Finished end = test::run({test::binary("cliquevo"), "simulate", "--out", folder, "--width", "320",
                                          "--height", "240", "--focal-px", "350", "--frames", std::to_string(kFrames)});
    EXPECT_EQ(end.exit_code, 0) << end.err;
    drivers::RecordingOptions options;
    options.path = folder;
    auto source = drivers::open_recording(options);
    EXPECT_TRUE(source.ok());
    StereoPair pair;
    for (int i = 0; i < kFrames && source.ok() && (*source)->next(pair).ok(); ++i) {
      left_[hash_of(pair.left.cview())] = i;
      right_[hash_of(pair.right.cview())] = i;
    }
  }
  // Which pair it is, byte for byte; -1: none, so torn or of two exposures.
  int number_of(const StereoPair& pair) const {
    const auto l = left_.find(hash_of(pair.left.cview()));
    const auto r = right_.find(hash_of(pair.right.cview()));
    return l == left_.end() || r == right_.end() || l->second != r->second ? -1 : l->second;
  }
  const std::string folder;

 private:
  std::map<std::uint64_t, int> left_;
  std::map<std::uint64_t, int> right_;
};

// The simulated cameras as a user starts them.
class Rig {
 public:
  Rig(const Course& course, const std::vector<std::string>& more) {
    command_ = {test::binary("cliquevo"), "hil", course.folder};
    command_.insert(command_.end(), more.begin(), more.end());
    start();
  }
  void start() { process_ = std::make_unique<test::Subprocess>(command_); }
  // As soon as both answer.
  void wait_until_seen() const {
    for (int i = 0; i < 60 && drivers::list_aravis().size() < 2; ++i) {
    }
  }
  void kill() {
    process_->send(SIGKILL);
    process_->wait();
  }

 private:
  std::vector<std::string> command_;
  std::unique_ptr<test::Subprocess> process_;
};

inline drivers::CameraOptions camera_options(const Course& course, double rate_hz) {
  drivers::CameraOptions options;
  options.left = "HIL-LEFT";
  options.right = "HIL-RIGHT";
  options.calibration = course.folder + "/calib.txt";
  options.rate_hz = rate_hz;
  options.exposure_us = 10'000;
  options.gain = 0;
  options.shared_clock = true;
  return options;
}

// As soon as they answer.
inline std::unique_ptr<drivers::FrameSource> open(const drivers::CameraOptions& options) {
  const auto give_up = steady_clock::now() + std::chrono::seconds(60);
  for (;;) {
    drivers::OpenTrouble ignored = drivers::OpenTrouble::lasting;
    auto source = drivers::open_aravis(options, ignored);
    if (source.ok()) return std::move(*source);
    if (steady_clock::now() > give_up) {
      ADD_FAILURE() << source.error().line();
      return nullptr;
    }
  }
}

struct Seen {
  std::int64_t pairs = 0;
  std::int64_t wrong = 0;
  std::vector<std::int64_t> stamps_us;
};
// Takes pairs until `wanted` have come or none came for long.
inline Seen take(drivers::FrameSource& source, const Course& course, std::int64_t wanted) {
  Seen seen;
  StereoPair pair;
  std::atomic<std::int64_t> last_ns{monotonic_ns()};
  std::atomic<bool> done{false};
  std::thread guard([&] {
    while (!done) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      if (monotonic_ns() - last_ns > 60'000'000'000) source.interrupt();
    }
  });
  while (seen.pairs < wanted) {
    const auto more = source.next(pair);
    if (!more.ok() || !*more) break;
    last_ns = monotonic_ns();
    const int number = course.number_of(pair);
    seen.wrong += number < 0 ? 1 : 0;
    seen.stamps_us.push_back(pair.stamp_ns / 1000);
    ++seen.pairs;
  }
  done = true;
  guard.join();
  return seen;
}

#define CLIQUEVO_NEEDS_TWO_ADDRESSES()                      \
  if (!::cliquevo::hil::enter_network_with_two_addresses()) \
  GTEST_SKIP() << "needs root and iproute2 for a network namespace"

}  // namespace cliquevo::hil
