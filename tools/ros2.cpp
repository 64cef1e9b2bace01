// SPDX-License-Identifier: BSD-3-Clause
// cliquevo ros2: runs the bridge, a program of its own with libraries of its own.
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <string>
#include <system_error>
#include <unistd.h>
#include <vector>

#include "tools/commands.h"
#include "tools/exit_code.h"

namespace cliquevo::tools {

namespace {

namespace fs = std::filesystem;

int run(const std::vector<std::string>& arguments) {
  std::error_code ec;
  const fs::path program = fs::read_symlink("/proc/self/exe", ec);
  std::string bridge = (program.parent_path().parent_path() / "lib/cliquevo/ros2").string();
  if (!fs::exists(bridge, ec)) {
    return report({"the bridge to ROS 2 is not installed", bridge, "install cliquevo-ros2"});
  }
  std::vector<std::string> words{bridge};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  argv.reserve(words.size() + 1);
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  ::execv(bridge.c_str(), argv.data());
  return report({"cannot run the bridge to ROS 2", bridge, std::strerror(errno)});
}

}  // namespace

void add_ros2_command(CliCommand app, int& exit_code) {
  const CliCommand ros2 = app.add_subcommand("ros2", "Publish the running daemon's odometry for ROS 2 (/odom, /tf)");
  ros2.pass_on_everything();  // the bridge knows the options
  ros2.callback([ros2, &exit_code] { exit_code = run(ros2.passed_on()); });
}

}  // namespace cliquevo::tools
