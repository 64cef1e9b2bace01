// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/machine.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <unistd.h>

namespace cliquevo::daemon {

namespace fs = std::filesystem;

std::int64_t resident_bytes() {
  std::ifstream in("/proc/self/statm");
  std::int64_t total = 0;
  std::int64_t resident = 0;
  if (!(in >> total >> resident)) return 0;
  return resident * ::sysconf(_SC_PAGESIZE);
}

std::vector<std::pair<std::string, double>> temperatures() {
  std::vector<std::pair<std::string, double>> out;
  std::error_code ec;
  for (fs::directory_iterator it("/sys/class/thermal", ec); !ec && it != fs::directory_iterator(); it.increment(ec)) {
    const fs::directory_entry& zone = *it;
    if (zone.path().filename().string().rfind("thermal_zone", 0) != 0) continue;
    std::ifstream type(zone.path() / "type");
    std::ifstream temperature(zone.path() / "temp");
    std::string name;
    double millidegrees = 0.0;
    if (std::getline(type, name) && temperature >> millidegrees) out.emplace_back(name, millidegrees / 1000.0);
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace cliquevo::daemon
