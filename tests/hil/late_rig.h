// SPDX-License-Identifier: BSD-3-Clause
// A daemon on two simulated cameras, in a private network.
#pragma once

#include <chrono>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "tests/hil/private_network.h"
#include "tests/support/subprocess.h"
#include "tests/support/test_data.h"

namespace cliquevo::hil {

inline constexpr const char* kUrl = "udpm://239.255.76.67:7667?ttl=0";

inline bool enter_network_with_two_addresses() {
  return test::enter_private_network() && std::system("for i in 2 9; do ip address add 127.0.0.$i/8 dev lo; done") == 0;
}

#define CLIQUEVO_NEEDS_TWO_ADDRESSES()                      \
  if (!::cliquevo::hil::enter_network_with_two_addresses()) \
  GTEST_SKIP() << "needs root and iproute2 for a network namespace"

inline std::string make_course() {
  const std::string folder = test::scratch_dir() + "/course";
  const test::Finished end = test::run({test::binary("cliquevo"), "simulate", "--out", folder, "--width", "320",
                                        "--height", "240", "--focal-px", "350", "--frames", "20"});
  EXPECT_EQ(end.exit_code, 0) << end.err;
  return folder;
}

inline std::string write_config(const std::string& dir, const std::string& calibration, const std::string& more = "") {
  const std::string path = dir + "/c.yaml";
  std::ofstream(path) << "source:\n  type: aravis\n  cameras: {left: HIL-LEFT, right: "
                         "HIL-RIGHT, calibration: "
                      << calibration << ", rate_hz: 10, exposure_us: 10000, gain: 0, shared_clock: true" << more
                      << "}\nrealtime: {lock_memory: false}\nlcm: {url: \"" << kUrl << "\"}\n";
  return path;
}

inline bool until(const std::function<bool()>& holds, double seconds = 60.0) {
  const auto give_up = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  while (!holds()) {
    if (std::chrono::steady_clock::now() > give_up) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return true;
}

inline std::size_t poses(const std::string& path) { return test::lines_of(test::read_file(path)).size(); }

inline std::size_t occurrences(const std::string& text, const std::string& words) {
  std::size_t count = 0;
  for (std::size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) ++count;
  return count;
}

}  // namespace cliquevo::hil
