// SPDX-License-Identifier: BSD-3-Clause
// cliquevo echo: the messages of a channel, as they come.
#include <algorithm>
#include <memory>
#include <string>

#include <fmt/format.h>

#include "core/base/printable.h"
#include "daemon/pipeline/lcm_config.h"
#include "tools/commands.h"
#include "tools/exit_code.h"
#include "tools/lcm_listener.h"
#include "tools/message_json.h"
#include "tools/stop_on_signal.h"

namespace cliquevo::tools {

namespace {

struct EchoArguments {
  std::string channel;
  std::string url = daemon::LcmConfig{}.url;
  bool json = false;
  std::int64_t count = 0;  // 0 = without end
};

// A member a line; lists on one.
std::string as_lines(const nlohmann::ordered_json& message) {
  std::string out;
  for (const auto& [name, value] : message.items()) {
    out += fmt::format("{}: {}\n", name, value.is_string() ? printable(value.get<std::string>()) : value.dump());
  }
  return out;
}

// Only what a channel's name is made of: LCM would read more as a regular expression.
bool is_name(const std::string& channel) {
  return !channel.empty() && channel.size() < 64 && std::all_of(channel.begin(), channel.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-';
  });
}

int run(const EchoArguments& arguments) {
  if (!is_name(arguments.channel)) {
    return report({"not a channel's name", printable(arguments.channel), "letters, digits, _ and -"}, kWrongUsage);
  }
  const StopOnSignal signals;
  std::int64_t printed = 0;
  std::int64_t unknown = 0;
  const auto print = [&](const ReceivedMessage& message) {
    const auto read = message_json(message.data, message.size);
    if (!read) {
      if (++unknown == 1) warn({"not a message of ours", arguments.channel, "left out, as are others like it"});
      return;
    }
    if (arguments.count > 0 && printed >= arguments.count) return;
    ++printed;
    constexpr auto kReplace = nlohmann::ordered_json::error_handler_t::replace;
    fmt::print("{}\n", arguments.json ? read->dump(-1, ' ', false, kReplace) : as_lines(*read));
    std::fflush(stdout);
  };
  auto listener = LcmListener::open(arguments.url, arguments.channel, print);
  if (!listener) return report(listener.error());
  while (!StopOnSignal::received() && (arguments.count == 0 || printed < arguments.count)) {
    if (auto ok = listener->wait(100); !ok) return report(ok.error());
    if (std::ferror(stdout) != 0) break;  // nobody reads any more
  }
  return kDone;
}

}  // namespace

void add_echo_command(CliCommand app, int& exit_code) {
  auto arguments = std::make_shared<EchoArguments>();
  const CliCommand echo = app.add_subcommand("echo", "Print the messages of a channel as they come");
  echo.add_option("CHANNEL", arguments->channel, "POSE_BODY, VO_DELTA_CAMERA, VO_STATUS, VO_HEALTH, ...").required();
  echo.add_flag("--json", arguments->json, "A line of JSON a message");
  echo.add_option("--count", arguments->count, "End after so many messages (default: with Ctrl-C)")
      .between(std::int64_t{1}, std::int64_t{1'000'000'000})
      .type_name("N");
  echo.add_option("--lcm", arguments->url, "LCM URL").type_name("URL").capture_default_str();
  echo.footer(
      "Of images the sizes and the camera are printed, not the pixels.\n"
      "Examples:\n"
      "  cliquevo echo VO_HEALTH\n"
      "  cliquevo echo POSE_BODY --json | jq .pos");
  echo.callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace cliquevo::tools
