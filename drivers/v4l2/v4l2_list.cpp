// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <fcntl.h>
#include <filesystem>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <system_error>
#include <unistd.h>

#include <fmt/format.h>

#include "drivers/v4l2.h"
#include "drivers/v4l2/v4l2_camera.h"

namespace cliquevo::drivers {

namespace {

namespace fs = std::filesystem;

// The name that stays when cameras are plugged in in another order; the device's own where there is none.
std::string stable_name(const std::string& device) {
  std::error_code ec;
  for (const char* folder : {"/dev/v4l/by-id", "/dev/v4l/by-path"}) {
    for (fs::directory_iterator entry(folder, ec); !ec && entry != fs::directory_iterator(); entry.increment(ec)) {
      if (fs::canonical(entry->path(), ec) == device) return entry->path().string();
    }
    ec.clear();
  }
  return device;
}

}  // namespace

std::vector<SeenCamera> list_v4l2() {
  std::vector<std::string> devices;
  std::error_code ec;
  for (fs::directory_iterator entry("/dev", ec); !ec && entry != fs::directory_iterator(); entry.increment(ec)) {
    if (entry->path().filename().string().starts_with("video")) devices.push_back(entry->path().string());
  }
  std::sort(devices.begin(), devices.end(), [](const std::string& a, const std::string& b) {
    return a.size() != b.size() ? a.size() < b.size() : a < b;
  });
  std::vector<SeenCamera> out;
  for (const std::string& device : devices) {
    const int descriptor = ::open(device.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    if (descriptor < 0) continue;
    v4l2_capability capability = {};
    const bool answered = ::ioctl(descriptor, VIDIOC_QUERYCAP, &capability) == 0;
    const std::uint32_t can =
        (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : capability.capabilities;
    if (answered && (can & V4L2_CAP_VIDEO_CAPTURE) != 0) {
      SeenCamera camera{"v4l2",
                        stable_name(device),
                        fmt::format("{} at {} ({})", reinterpret_cast<const char*>(capability.card), device,
                                    reinterpret_cast<const char*>(capability.bus_info)),
                        {}};
      for (const std::uint32_t fourcc : v4l2_formats(descriptor)) camera.formats.push_back(fourcc_name(fourcc));
      out.push_back(std::move(camera));
    }
    ::close(descriptor);
  }
  return out;
}

}  // namespace cliquevo::drivers
