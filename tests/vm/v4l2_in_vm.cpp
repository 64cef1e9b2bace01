// SPDX-License-Identifier: BSD-3-Clause
// Runs inside the virtual machine: the V4L2 driver on a simulated UVC pair (stock uvcvideo) and on vivid. Prints what
// it does; exit code 0 when all held.
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <grp.h>
#include <linux/videodev2.h>
#include <map>
#include <string>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "drivers/v4l2.h"
#include "drivers/v4l2/v4l2_pairs.h"
#include "tests/vm/in_vm.h"

namespace {

namespace fs = std::filesystem;
using namespace cliquevo;
using drivers::CameraOptions;
using drivers::OpenTrouble;
using drivers::StereoPair;
using drivers::V4l2Pairs;
using test::check;
using test::failures;
using test::plug_in;
using test::Seen;
using test::take_true_pairs;
using test::trouble;

// The capture devices whose driver has this name, by bus: in the order of their ports.
std::map<std::string, std::string> devices_of(const std::string& driver) {
  std::map<std::string, std::string> out;
  for (int i = 0; i < 16; ++i) {
    const std::string path = "/dev/video" + std::to_string(i);
    const int descriptor = ::open(path.c_str(), O_RDWR | O_NONBLOCK);
    if (descriptor < 0) continue;
    v4l2_capability capability = {};
    if (::ioctl(descriptor, VIDIOC_QUERYCAP, &capability) == 0 &&
        driver == reinterpret_cast<const char*>(capability.driver) &&
        (capability.device_caps & V4L2_CAP_VIDEO_CAPTURE) != 0) {
      out[reinterpret_cast<const char*>(capability.bus_info)] = path;
    }
    ::close(descriptor);
  }
  return out;
}

// A stable name for whatever node the camera has now, as udev would keep it.
void keep_names(const std::string& driver) {
  const auto devices = devices_of(driver);
  int i = 0;
  for (const auto& [bus, path] : devices) {
    const std::string link = i++ == 0 ? "/dev/camera-left" : "/dev/camera-right";
    std::error_code ignored;
    fs::remove(link, ignored);
    fs::create_symlink(path, link, ignored);
  }
}

bool wait_for_devices(const std::string& driver, std::size_t count) {
  for (int i = 0; i < 600; ++i) {
    if (devices_of(driver).size() == count) return true;
    ::usleep(100'000);
  }
  return false;
}

CameraOptions options_for(double rate_hz) {
  CameraOptions options;
  options.left = "/dev/camera-left";
  options.right = "/dev/camera-right";
  options.rate_hz = rate_hz;
  return options;
}

// In a process of a user that is in no group.
bool as_nobody(bool (*holds)()) {
  const pid_t child = ::fork();
  if (child == 0) {
    const bool nobody = ::setgroups(0, nullptr) == 0 && ::setgid(65534) == 0 && ::setuid(65534) == 0;
    ::_exit(nobody && holds() ? 0 : 1);
  }
  int status = 1;
  ::waitpid(child, &status, 0);
  return status == 0;
}

void uvc_pair() {
  pid_t left = plug_in("0", "LEFT", "1");
  pid_t right = plug_in("1", "RIGHT", "2");
  check(wait_for_devices("uvcvideo", 2), "two UVC cameras appear");
  keep_names("uvcvideo");
  const auto listed = drivers::list_v4l2();
  check(listed.size() == 2 && listed[0].formats == std::vector<std::string>{"YUYV"},
        "both are listed with their format");
  {
    CameraOptions wrong = options_for(10.0);
    wrong.pixel_format = "MJPG";
    const auto refused = V4l2Pairs::open(wrong, trouble);
    check(!refused.ok() && trouble == OpenTrouble::lasting &&
              refused.error().line().find("it offers YUYV") != std::string::npos,
          "a format that is not offered: " + (refused.ok() ? std::string("taken") : refused.error().line()));
    wrong = options_for(10.0);
    wrong.left = "/dev/video77";
    const auto missing = V4l2Pairs::open(wrong, trouble);
    check(!missing.ok() && trouble == OpenTrouble::absent,
          "no such camera: " + (missing.ok() ? std::string("taken") : missing.error().line()));
  }
  std::ofstream("/etc/group") << "root:x:0:\nvideo:x:44:\n";
  for (const char* side : {"/dev/camera-left", "/dev/camera-right"}) {  // as udev does it
    check(::chown(side, 0, 44) == 0 && ::chmod(side, 0660) == 0, "the node is the group's");
  }
  check(as_nobody([] {
          const auto refused = V4l2Pairs::open(options_for(10.0), trouble);
          return !refused.ok() && refused.error().line().find("adduser USER video") != std::string::npos;
        }),
        "without the right to them, the group is named");
  auto pairs = V4l2Pairs::open(options_for(10.0), trouble);
  check(pairs.ok(), "they open" + (pairs.ok() ? std::string() : ": " + pairs.error().line()));
  if (!pairs.ok()) return;
  {
    const auto busy = V4l2Pairs::open(options_for(10.0), trouble);
    check(!busy.ok() && trouble == OpenTrouble::held && busy.error().line().find("busy") != std::string::npos,
          "a second program finds them busy: " + (busy.ok() ? std::string("opened") : busy.error().line()));
  }
  const Seen first = take_true_pairs(**pairs, 20);
  check(first.pairs == 20 && first.wrong == 0,
        "20 pairs, each of one exposure, every byte exact; " + (*pairs)->status());
  ::kill(right, SIGKILL);
  ::waitpid(right, nullptr, 0);
  for (int i = 0; i < 600 && (*pairs)->status().find("right camera: ") == std::string::npos; ++i) ::usleep(100'000);
  check((*pairs)->status().find("right camera: ") != std::string::npos, "unplugged: " + (*pairs)->status());
  for (int i = 0; i < 600 && devices_of("uvcvideo").size() != 1; ++i) ::usleep(100'000);
  right = plug_in("1", "RIGHT", "2");
  check(wait_for_devices("uvcvideo", 2), "plugged in again it appears");
  keep_names("uvcvideo");
  const Seen second = take_true_pairs(**pairs, 10);
  check(second.pairs == 10 && second.wrong == 0,
        "10 pairs more, each of one exposure, every byte exact; " + (*pairs)->status());
  pairs->reset();
  for (const pid_t camera : {left, right}) {
    ::kill(camera, SIGKILL);
    ::waitpid(camera, nullptr, 0);
  }
}

// A control of vivid by the name that the driver lists it under.
bool press(const std::string& device, const std::string& name) {
  const int descriptor = ::open(device.c_str(), O_RDWR | O_NONBLOCK);
  if (descriptor < 0) return false;
  v4l2_queryctrl query = {};
  query.id = V4L2_CTRL_FLAG_NEXT_CTRL;
  bool pressed = false;
  while (!pressed && ::ioctl(descriptor, VIDIOC_QUERYCTRL, &query) == 0) {
    if (name == reinterpret_cast<const char*>(query.name)) {
      v4l2_control control = {query.id, 1};
      pressed = ::ioctl(descriptor, VIDIOC_S_CTRL, &control) == 0;
    }
    query.id |= V4L2_CTRL_FLAG_NEXT_CTRL;
  }
  ::close(descriptor);
  return pressed;
}

int take_pairs(V4l2Pairs& pairs, int wanted) {
  StereoPair pair;
  int count = 0;
  while (count < wanted && pairs.next(pair)) ++count;
  return count;
}

int control_of(const std::string& device, std::uint32_t id) {
  const int descriptor = ::open(device.c_str(), O_RDWR | O_NONBLOCK);
  v4l2_control control = {id, -1};
  if (descriptor < 0 || ::ioctl(descriptor, VIDIOC_G_CTRL, &control) != 0) control.value = -1;
  ::close(descriptor);
  return control.value;
}

void vivid_appears() {
  check(std::system("modprobe vivid n_devs=2 node_types=0x1,0x1 num_inputs=1,1 input_types=0,0") == 0, "vivid loads");
  check(wait_for_devices("vivid", 2), "two vivid cameras appear");
  keep_names("vivid");
}

// Controls by name reach both cameras, and the right one takes over the gain that the left one's control has found.
void vivid_controls() {
  const std::string left = fs::canonical("/dev/camera-left").string();
  const std::string right = fs::canonical("/dev/camera-right").string();
  CameraOptions options = options_for(10.0);
  options.pixel_format = "GREY";
  options.width = 320;
  options.height = 180;
  options.controls = "brightness=77,saturation=50";
  {
    auto pairs = V4l2Pairs::open(options, trouble);
    check(pairs.ok(), "two of them open" + (pairs.ok() ? std::string() : ": " + pairs.error().line()));
    if (!pairs.ok()) return;
    for (const std::string& side : {left, right}) {
      check(control_of(side, V4L2_CID_BRIGHTNESS) == 77 && control_of(side, V4L2_CID_SATURATION) == 50,
            "the controls named are set: " + side);
    }
    check(control_of(left, V4L2_CID_AUTOGAIN) == 1 && control_of(right, V4L2_CID_AUTOGAIN) == 0,
          "the left camera's own control is on, the right one's off");
    // vivid's automatic gain is another one every second.
    int changes = 0, followed = 0, last = control_of(left, V4L2_CID_GAIN);
    for (int i = 0; i < 100 && changes < 3; ++i) {
      ::usleep(50'000);
      const int found = control_of(left, V4L2_CID_GAIN);
      if (found == last) continue;
      last = found;
      ++changes;
      for (int k = 0; k < 18 && control_of(right, V4L2_CID_GAIN) != found; ++k) ::usleep(50'000);
      followed += control_of(right, V4L2_CID_GAIN) == found ? 1 : 0;
    }
    check(changes == 3 && followed >= 2, "the right camera follows the left one's gain: " + std::to_string(followed) +
                                             " of " + std::to_string(changes) + " times");
  }
  options.controls = "no_such_thing=1";
  const auto refused = V4l2Pairs::open(options, trouble);
  check(!refused.ok() && refused.error().line().find("brightness") != std::string::npos,
        "an unknown control is refused, with those there are: " +
            (refused.ok() ? std::string() : refused.error().line()));
}

void vivid_faults() {
  // One camera that delivers both images: two that run freely are rarely in phase.
  CameraOptions options = options_for(10.0);
  options.layout = drivers::CameraLayout::side_by_side;
  options.pixel_format = "GREY";
  options.width = 320;
  options.height = 360;
  auto pairs = V4l2Pairs::open(options, trouble);
  check(pairs.ok(), "it opens" + (pairs.ok() ? std::string() : ": " + pairs.error().line()));
  if (!pairs.ok()) return;
  check((*pairs)->width() == 320, "one image is half of the frame");
  check(take_pairs(**pairs, 5) == 5, "pairs flow; " + (*pairs)->status());
  const std::string device = fs::canonical("/dev/camera-left").string();
  for (const char* fault : {"Inject V4L2_BUF_FLAG_ERROR", "Inject Fatal Streaming Error", "Disconnect"}) {
    const std::string before = (*pairs)->status();
    check(press(device, fault), std::string(fault) + " is injected");
    bool reported = false;
    for (int i = 0; i < 200 && !reported; ++i) {
      const std::string status = (*pairs)->status();
      reported = status.find("left camera: ") != std::string::npos ||
                 (status.find("incomplete") != std::string::npos && before.find("incomplete") == std::string::npos);
      ::usleep(5'000);
    }
    check(reported, std::string("it is reported: ") + (*pairs)->status());
    const bool again = take_pairs(**pairs, 10) == 10;
    check(again && (*pairs)->status().find("left camera: ") == std::string::npos,
          "pairs flow again; " + (*pairs)->status());
  }
}

}  // namespace

int main() {
  ::alarm(400);
  uvc_pair();
  vivid_appears();
  vivid_controls();
  vivid_faults();
  std::printf("%d failures\n", failures);
  return failures == 0 ? 0 : 1;
}
