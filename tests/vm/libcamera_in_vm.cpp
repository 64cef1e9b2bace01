// SPDX-License-Identifier: BSD-3-Clause
// Runs inside the virtual machine: the libcamera driver on a simulated UVC pair. Prints what it does; exit code 0 when
// all held.
#include <csignal>
#include <cstdio>
#include <string>
#include <sys/wait.h>
#include <unistd.h>

#include "drivers/libcamera.h"
#include "drivers/libcamera/libcamera_pairs.h"
#include "tests/vm/in_vm.h"

namespace {

using namespace cliquevo;
using drivers::LibcameraPairs;
using test::check;
using test::failures;
using test::plug_in;
using test::Seen;
using test::take_true_pairs;
using test::trouble;

void check_refusals(const drivers::CameraOptions& options) {
  drivers::CameraOptions wrong = options;
  wrong.left = "nowhere";
  const auto missing = LibcameraPairs::open(wrong, trouble);
  check(!missing.ok() && trouble == drivers::OpenTrouble::absent &&
            missing.error().line().find(options.left) != std::string::npos,
        "no such camera: " + (missing.ok() ? std::string("taken") : missing.error().line()));
  wrong = options;
  wrong.pixel_format = "NV16";
  const auto refused = LibcameraPairs::open(wrong, trouble);
  check(!refused.ok() && trouble == drivers::OpenTrouble::lasting &&
            refused.error().line().find("it offers YUYV") != std::string::npos,
        "a format that is not offered: " + (refused.ok() ? std::string("taken") : refused.error().line()));
}

}  // namespace

int main() {
  ::alarm(300);
  const pid_t left = plug_in("0", "LEFT", "1");
  pid_t right = plug_in("1", "RIGHT", "2");
  std::vector<drivers::SeenCamera> seen;
  for (int i = 0; i < 300 && ::access("/dev/video3", F_OK) != 0; ++i) ::usleep(100'000);
  ::sleep(2);  // udev gets to know them
  for (int i = 0; i < 100 && seen.size() < 2; ++i) {
    seen = drivers::list_libcamera();
    ::usleep(200'000);
  }
  check(seen.size() == 2, "libcamera lists two cameras: " + std::to_string(seen.size()));
  if (seen.size() != 2) return 1;
  for (const auto& camera : seen) std::printf("     %s (%s)\n", camera.id.c_str(), camera.description.c_str());
  drivers::CameraOptions options;
  const bool swapped = seen[0].id > seen[1].id;  // ids end with the port
  options.left = seen[swapped ? 1 : 0].id;
  options.right = seen[swapped ? 0 : 1].id;
  options.rate_hz = 10.0;
  check_refusals(options);
  // As the service starts where a camera comes late: the same tries in one process, until it is there.
  ::kill(right, SIGKILL);
  ::waitpid(right, nullptr, 0);
  for (int i = 0; i < 300 && drivers::list_libcamera().size() != 1; ++i) ::usleep(100'000);
  auto pairs = LibcameraPairs::open(options, trouble);
  check(!pairs.ok() && trouble == drivers::OpenTrouble::absent,
        "one is not there yet: " + (pairs.ok() ? std::string("taken") : pairs.error().line()));
  right = plug_in("1", "RIGHT", "2");
  for (int i = 0; i < 300 && !pairs.ok(); ++i) {
    ::usleep(200'000);
    pairs = LibcameraPairs::open(options, trouble);
  }
  check(pairs.ok(), "they open once it is plugged in" + (pairs.ok() ? std::string() : ": " + pairs.error().line()));
  if (!pairs.ok()) return 1;
  const Seen first = take_true_pairs(**pairs, 20);
  check(first.pairs == 20 && first.wrong == 0,
        "20 pairs, each of one exposure, every byte exact; " + (*pairs)->status());
  ::kill(right, SIGKILL);
  ::waitpid(right, nullptr, 0);
  for (int i = 0; i < 300 && (*pairs)->status().find("right camera: ") == std::string::npos; ++i) ::usleep(100'000);
  check((*pairs)->status().find("right camera: ") != std::string::npos, "unplugged: " + (*pairs)->status());
  ::sleep(2);
  right = plug_in("1", "RIGHT", "2");
  const Seen second = take_true_pairs(**pairs, 10);
  check(second.pairs == 10 && second.wrong == 0,
        "plugged in again: 10 pairs more, each of one exposure, every byte exact; " + (*pairs)->status());
  pairs->reset();
  ::kill(left, SIGKILL);
  ::kill(right, SIGKILL);
  std::printf("%d failures\n", failures);
  std::fflush(stdout);
  ::_exit(failures == 0 ? 0 : 1);  // libcamera's own threads need no farewell from a machine that is switched off
}
