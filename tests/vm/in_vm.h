// SPDX-License-Identifier: BSD-3-Clause
// What the programs that run inside the virtual machine share: checks that are printed, cameras that are plugged in,
// pairs that are looked at pixel by pixel.
#pragma once

#include <cstdio>
#include <string>
#include <unistd.h>

#include "drivers/frame_source.h"
#include "drivers/live/camera_options.h"
#include "tests/vm/made_up_yuyv.h"

namespace cliquevo::test {

inline int failures = 0;
inline drivers::OpenTrouble trouble = drivers::OpenTrouble::lasting;  // of the last one that did not open

inline void check(bool ok, const std::string& what) {
  std::printf("%s %s\n", ok ? "ok  " : "FAIL", what.c_str());
  std::fflush(stdout);
  if (!ok) ++failures;
}

// A simulated camera of 160 x 120 at 10 Hz; the seed is what its pixels are made up from.
inline pid_t plug_in(const char* port, const char* serial, const char* seed) {
  const pid_t child = ::fork();
  if (child == 0) {
    ::execl("/bin/uvc_camera", "uvc_camera", port, "160", "120", "10", serial, seed, nullptr);
    ::_exit(127);
  }
  return child;
}

struct Seen {
  int pairs = 0;
  int wrong = 0;
};
// Of cameras with the seeds 1 and 2.
template <typename Pairs>
Seen take_true_pairs(Pairs& pairs, int wanted) {
  Seen seen;
  drivers::StereoPair pair;
  while (seen.pairs < wanted && pairs.next(pair)) {
    const std::int64_t left = number_of(pair.left.cview(), 1);
    if (left < 0 || number_of(pair.right.cview(), 2) != left) ++seen.wrong;
    ++seen.pairs;
  }
  return seen;
}

}  // namespace cliquevo::test
