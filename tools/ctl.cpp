// SPDX-License-Identifier: BSD-3-Clause
#include "tools/ctl.h"

#include <memory>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/printable.h"
#include "daemon/control/control_client.h"
#include "daemon/pipeline/config.h"
#include "tools/exit_code.h"

namespace cliquevo::tools {

namespace {

struct CtlOptions {
  std::string socket = daemon::ControlConfig{}.socket;
  bool json = false;
};

int send(const CtlOptions& options, const std::string& request) {
  const auto reply = daemon::ask_daemon(options.socket, request);
  if (!reply) return report(reply.error());
  if (request != "status" || options.json) {
    fmt::print("{}\n", printable(*reply));
    return kDone;
  }
  const auto summary = status_summary(*reply);
  if (!summary) return report(summary.error());
  fmt::print("{}", *summary);
  return kDone;
}

}  // namespace

Result<std::string> status_summary(const std::string& json) {
  const auto status = nlohmann::json::parse(json, nullptr, false);
  if (!status.is_object()) return Error{"cannot read the status", "the daemon's reply", "use the daemon's own version"};
  const auto number = [&status](const char* key) {
    const auto found = status.find(key);
    return found != status.end() && found->is_number() ? found->get<double>() : 0.0;
  };
  const auto text = [&status](const char* key) {
    const auto found = status.find(key);
    return found != status.end() && found->is_string() ? printable(found->get<std::string>()) : std::string();
  };
  const std::string state = text("state_text").empty() ? text("state") : text("state_text");
  std::string out = fmt::format("{:<12}{}, up {:.0f} s\n", "state", state, number("uptime_s"));
  out += fmt::format("{:<12}{:.1f} Hz, {:.0f} % valid, latency {:.1f} ms (p99 {:.1f} ms)\n", "poses",
                     number("pose_rate_hz"), 100.0 * number("valid_share"), 1e-3 * number("latency_p50_us"),
                     1e-3 * number("latency_p99_us"));
  out += fmt::format("{:<12}{:.0f} grabbed, {:.0f} dropped, {:.0f} rejected, {:.0f} resets\n", "frames",
                     number("frames_grabbed"), number("frames_dropped"), number("frames_rejected"), number("resets"));
  out += fmt::format("{:<12}{:.0f} of the source, {:.0f} of sending\n", "errors", number("source_errors"),
                     number("send_errors"));
  out += fmt::format("{:<12}{:.0f} MB\n", "memory", 1e-6 * number("resident_bytes"));
  for (const auto& [name, key] : {std::pair{"source", "source_text"}, std::pair{"recording", "recording_text"},
                                  std::pair{"incidents", "incident_text"}, std::pair{"calibration", "calibration_text"},
                                  std::pair{"view", "view_text"}}) {
    if (!text(key).empty()) out += fmt::format("{:<12}{}\n", name, text(key));
  }
  return out;
}

void add_ctl_command(CliCommand app, int& exit_code) {
  auto options = std::make_shared<CtlOptions>();
  const CliCommand ctl = app.add_subcommand("ctl", "Send the running daemon a command, or show its status");
  ctl.add_option("--socket", options->socket, "The daemon's control.socket").type_name("PATH").capture_default_str();
  ctl.require_subcommand();
  ctl.fallthrough();  // --socket may come behind
  for (const auto& [request, text] :
       {std::pair{"reset", "The next frame is the pose's origin"},
        std::pair{"record-start", "Begin a recording in recording.folder; nothing happens while one is written"},
        std::pair{"record-stop", "End the recording"}, std::pair{"status", "State, rates, latency, recording"}}) {
    const CliCommand one = ctl.add_subcommand(request, text);
    if (std::string(request) == "status") one.add_flag("--json", options->json, "As JSON, with every figure");
    one.callback([options, &exit_code, word = std::string(request)] { exit_code = send(*options, word); });
  }
  ctl.footer(
      "The socket is for the daemon's user and group: usermod -aG cliquevo USER lets USER command it.\n"
      "Examples:\n"
      "  cliquevo ctl status\n"
      "  cliquevo ctl record-start --socket /tmp/control");
}

}  // namespace cliquevo::tools
