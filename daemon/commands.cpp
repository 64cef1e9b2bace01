// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/commands.h"

#include <filesystem>
#include <system_error>
#include <utility>

#include <spdlog/spdlog.h>

#include "daemon/lcm/lcm_url.h"
#include "daemon/lcm/status_report.h"
#include "daemon/log.h"

namespace cliquevo::daemon {

Result<std::string> Commands::handle(Command command) {
  switch (command) {
    case Command::reset_pose:
      pipeline_.request_reset();
      incidents_.log("the pose is reset, by command");
      return std::string("the next frame is the origin");
    case Command::start_recording:
      if (const auto ok = recording_.start(); !ok) return ok.error();
      return std::string("recording");
    case Command::stop_recording:
      if (const auto ok = recording_.stop(); !ok) return ok.error();
      return std::string("not recording");
  }
  return Error{"no command", "cliquevod", "see cliquevo ctl --help"};
}

void Commands::listen(const Config& config) {
  const auto handler = [this](Command command) { return handle(command); };
  const std::string& path = config.control.socket;
  std::error_code ec;
  if (!path.empty() && !std::filesystem::is_directory(std::filesystem::path(path).parent_path(), ec)) {
    // As started by hand; systemd makes it for the service.
    spdlog::info("no control socket: its folder is not there: {}", path);
  } else if (!path.empty()) {
    const auto status = [this] {
      const std::lock_guard<std::mutex> lock(mutex_);
      return status_;
    };
    auto socket = ControlSocket::open(path, {handler, status});
    if (!socket) report(socket.error());
    if (socket) socket_.emplace(std::move(*socket));
  }
  const LcmConfig& lcm = config.lcm;
  if (lcm.command_channel.empty()) return;
  auto receiver = CommandReceiver::start(lcm.url, lcm.command_channel, handler, incidents_);
  if (!receiver) return report(receiver.error());
  receiver_.emplace(std::move(*receiver));
  const auto group = parse_multicast_url(lcm.url);
  spdlog::warn("commands are taken from the channel {}: {} can reset the pose and record", lcm.command_channel,
               group && group->ttl > 0 ? "every machine that reaches the group" : "every program of this machine");
}

void Commands::set_status(const health_t& health) {
  std::string status = status_json(health, CLIQUEVO_VERSION);
  const std::lock_guard<std::mutex> lock(mutex_);
  status_ = std::move(status);
}

}  // namespace cliquevo::daemon
