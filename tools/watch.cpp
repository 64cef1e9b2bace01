// SPDX-License-Identifier: BSD-3-Clause
// cliquevo watch: the daemon at a glance, in a terminal.
#include <memory>
#include <string>
#include <unistd.h>

#include <fmt/format.h>

#include "daemon/lcm/message_sizes.h"
#include "daemon/pipeline/lcm_config.h"
#include "tools/commands.h"
#include "tools/exit_code.h"
#include "tools/lcm_listener.h"
#include "tools/stop_on_signal.h"
#include "tools/watch_lines.h"

namespace cliquevo::tools {

namespace {

struct WatchArguments {
  std::string url = daemon::LcmConfig{}.url;
  double seconds = 0.0;  // 0 = without end
};

template <typename Message>
bool taken(const ReceivedMessage& received, WatchedDaemon& watched) {
  Message message;
  if (!daemon::decode_checked(received.data, received.size, message)) return false;
  watched.take(message, monotonic_ns());
  return true;
}

int run(const WatchArguments& arguments) {
  constexpr TimestampNs kRefreshNs = 500'000'000;
  constexpr TimestampNs kLineNs = 1'000'000'000;
  const StopOnSignal signals;
  WatchedDaemon watched;
  auto listener =
      LcmListener::open(arguments.url, "VO_STATUS|VO_HEALTH|POSE_BODY", [&watched](const ReceivedMessage& received) {
        // A message of another type or a damaged one is left out.
        static_cast<void>(taken<status_t>(received, watched) || taken<health_t>(received, watched) ||
                          taken<pose_t>(received, watched));
      });
  if (!listener) return report(listener.error());
  const bool terminal = ::isatty(STDOUT_FILENO) == 1;
  const TimestampNs start_ns = monotonic_ns();
  TimestampNs next_ns = start_ns + (terminal ? 0 : kLineNs);
  while (!StopOnSignal::received()) {
    if (auto ok = listener->wait(50); !ok) return report(ok.error());
    const TimestampNs now_ns = monotonic_ns();
    if (now_ns >= next_ns) {
      next_ns = now_ns + (terminal ? kRefreshNs : kLineNs);
      // Home, then each line to its end, then what is below: nothing flickers.
      std::string text = terminal ? watched.lines(now_ns) : watched.line(now_ns);
      for (std::size_t at = 0; terminal && (at = text.find('\n', at)) != std::string::npos; at += 4) {
        text.insert(at, "\x1b[K");
      }
      fmt::print("{}{}{}", terminal ? "\x1b[H" : "", text, terminal ? "\x1b[J" : "");
      std::fflush(stdout);
      if (std::ferror(stdout) != 0) break;  // nobody reads any more
    }
    if (arguments.seconds > 0.0 && static_cast<double>(now_ns - start_ns) * 1e-9 >= arguments.seconds) break;
  }
  return kDone;
}

}  // namespace

void add_watch_command(CliCommand app, int& exit_code) {
  auto arguments = std::make_shared<WatchArguments>();
  const CliCommand watch =
      app.add_subcommand("watch", "See in the terminal how the daemon gets on: state, rate, verdicts");
  watch.add_option("--lcm", arguments->url, "LCM URL of the daemon").type_name("URL").capture_default_str();
  watch.add_option("--seconds", arguments->seconds, "End after so long (default: with Ctrl-C)")
      .between(0.1, 1e6)
      .type_name("S");
  watch.footer(
      "It listens to VO_HEALTH, VO_STATUS and POSE_BODY. Where the output is no terminal, it prints a line a second.\n"
      "`cliquevo ctl status` has the daemon's own figures.");
  watch.callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace cliquevo::tools
