// SPDX-License-Identifier: BSD-3-Clause
#include "tests/system/booted_root.h"

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <thread>
#include <unistd.h>

namespace cliquevo::test {

namespace {

namespace fs = std::filesystem;

std::string folder() {
  const char* set = std::getenv("CLIQUEVO_SERVICE_ROOT");
  return set != nullptr && *set != '\0' ? set : std::string(CLIQUEVO_BUILD_DIR) + "/service-root";
}

void pause() { std::this_thread::sleep_for(std::chrono::milliseconds(50)); }

std::string first_line(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

std::vector<pid_t> numbers_in(const fs::path& path) {
  std::vector<pid_t> out;
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(path, error)) {
    const std::string name = entry.path().filename();
    if (name.find_first_not_of("0123456789") == std::string::npos) out.push_back(std::stoi(name));
  }
  return out;
}

}  // namespace

std::string install_package() {
  if (::geteuid() != 0) return "needs root to boot a container";
  for (const char* tool : {"systemd-nspawn", "mmdebstrap", "nsenter"}) {
    if (test::run({"which", tool}).exit_code != 0) return std::string("needs ") + tool;
  }
  const std::string packed = folder() + "/package";
  const Finished pack = Subprocess({"cpack", "-G", "DEB", "-D", "CPACK_COMPONENTS_ALL=runtime", "--config",
                                    std::string(CLIQUEVO_BUILD_DIR) + "/CPackConfig.cmake", "-B", packed})
                            .wait(300.0);
  if (pack.exit_code != 0) return "cpack: " + pack.out + pack.err;
  for (const fs::directory_entry& entry : fs::directory_iterator(packed)) {
    if (!entry.path().filename().string().starts_with("cliquevo_")) continue;  // what a vehicle installs
    const Finished made =
        Subprocess({std::string(CLIQUEVO_SOURCE_DIR) + "/tests/system/service_root", entry.path(), folder()})
            .wait(900.0);
    if (made.exit_code != 0) return "service_root: " + made.out + made.err;
    return "";
  }
  return "cpack made no package in " + packed;
}

std::unique_ptr<BootedRoot> BootedRoot::boot(bool without_route) {
  std::unique_ptr<BootedRoot> self(new BootedRoot());
  std::vector<std::string> command{"systemd-nspawn",
                                   "--quiet",
                                   "--directory=" + folder() + "/root",
                                   "--boot",
                                   "--register=no",
                                   "--keep-unit",
                                   "--private-network",
                                   "--volatile=overlay",
                                   "--console=pipe",
                                   "--capability=CAP_IPC_LOCK,CAP_SYS_NICE",
                                   "--rlimit=RLIMIT_MEMLOCK=infinity"};
  // In a chroot / is no mount, and nspawn wants one: the same tree, seen where it is.
  if (test::run({"mountpoint", "-q", "/"}).exit_code != 0) {
    const std::string seen = folder() + "/seen";
    fs::create_directories(seen);
    command.insert(command.begin(), {"unshare", "--mount", "--propagation", "unchanged", "sh", "-c",
                                     R"(mount --rbind / "$0" && exec chroot "$0" "$@")", seen});
  }
  self->nspawn_ = std::make_unique<Subprocess>(command);
  for (int i = 0; i < 1200; ++i, pause()) {
    const pid_t nspawn = self->nspawn_->pid();
    const std::string children =
        first_line("/proc/" + std::to_string(nspawn) + "/task/" + std::to_string(nspawn) + "/children");
    self->enter_ = children.substr(0, children.find(' '));
    if (self->enter_.empty()) continue;
    const std::string state = self->run({"systemctl", "is-system-running"}).out;
    if (state != "running\n" && state != "degraded\n") continue;
    if (without_route) return self;
    for (const std::vector<std::string>& step : {std::vector<std::string>{"ip", "link", "set", "lo", "multicast", "on"},
                                                 {"ip", "route", "add", "224.0.0.0/4", "dev", "lo"}}) {
      if (test::run(self->in_its_network(step)).exit_code != 0) return nullptr;
    }
    return self;
  }
  return nullptr;
}

BootedRoot::~BootedRoot() {
  if (!nspawn_ || enter_.empty()) return;
  run({"systemctl", "poweroff"});
  nspawn_->wait(20.0);
}

Finished BootedRoot::run(const std::vector<std::string>& command) const {
  std::vector<std::string> all{"nsenter", "-t", enter_, "-m", "-p", "-n", "-u", "-i", "-C", "-r", "-w"};
  all.insert(all.end(), command.begin(), command.end());
  return test::run(all);
}

std::vector<std::string> BootedRoot::in_its_network(std::vector<std::string> command) const {
  command.insert(command.begin(), {"nsenter", "-t", enter_, "-n"});
  return command;
}

void BootedRoot::write(const std::string& path, const std::string& text) const {
  const fs::path seen_from_here = "/proc/" + enter_ + "/root" + path;
  fs::create_directories(seen_from_here.parent_path());
  std::ofstream(seen_from_here) << text;
}

std::string BootedRoot::property(const std::string& name) const {
  std::string out = run({"systemctl", "show", "cliquevod", "--value", "-p", name}).out;
  while (!out.empty() && out.back() == '\n') out.pop_back();
  return out;
}

bool BootedRoot::wait_for(const std::string& name, const std::string& value, double timeout_s) const {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(timeout_s);
  do {
    if (property(name) == value) return true;
    pause();
  } while (std::chrono::steady_clock::now() < end);
  return false;
}

std::optional<pid_t> BootedRoot::daemon() const {
  std::error_code error;
  const fs::path its = fs::read_symlink("/proc/" + enter_ + "/ns/pid", error);
  for (const pid_t pid : numbers_in("/proc")) {
    const std::string process = "/proc/" + std::to_string(pid);
    if (first_line(process + "/comm") == "cliquevod" && fs::read_symlink(process + "/ns/pid", error) == its) return pid;
  }
  return std::nullopt;
}

std::optional<pid_t> BootedRoot::thread_of_daemon(const std::string& name) const {
  const auto pid = daemon();
  if (!pid) return std::nullopt;
  const std::string tasks = "/proc/" + std::to_string(*pid) + "/task";
  for (const pid_t tid : numbers_in(tasks)) {
    if (first_line(tasks + "/" + std::to_string(tid) + "/comm") == name) return tid;
  }
  return std::nullopt;
}

}  // namespace cliquevo::test
