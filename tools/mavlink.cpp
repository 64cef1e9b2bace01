// SPDX-License-Identifier: BSD-3-Clause
// cliquevo mavlink: VO_ODOMETRY to an autopilot.
#include <algorithm>
#include <cerrno>
#include <memory>
#include <optional>
#include <poll.h>
#include <string>

#include <cliquevo/odometry_t.hpp>
#include <fmt/format.h>
#include <lcm/lcm-cpp.hpp>

#include "core/base/clock.h"
#include "daemon/lcm/lcm_url.h"
#include "daemon/pipeline/lcm_config.h"
#include "tools/commands.h"
#include "tools/exit_code.h"
#include "tools/mavlink_link.h"
#include "tools/mavlink_messages.h"
#include "tools/stop_on_signal.h"

namespace cliquevo::tools {

namespace {

struct MavlinkArguments {
  std::string to;
  std::string lcm_url = daemon::LcmConfig{}.url;
  std::string channel = daemon::LcmConfig{}.odometry_channel;
  std::string messages = "odometry";
  double rate_hz = 50.0;
  int system = 1;
  int component = 197;  // MAV_COMP_ID_VISUAL_INERTIAL_ODOMETRY
};

class Bridge {
 public:
  Bridge(const MavlinkArguments& arguments, MavlinkLink link)
      : arguments_(arguments),
        link_(std::move(link)),
        sender_(static_cast<std::uint8_t>(arguments.system), static_cast<std::uint8_t>(arguments.component)),
        period_us_(static_cast<std::int64_t>(1e6 / arguments.rate_hz)) {}

  int descriptor() const { return link_.descriptor(); }
  bool has_pending() const { return link_.has_pending(); }
  const std::optional<Error>& failure() const { return failure_; }
  std::int64_t sent() const { return sent_; }
  std::int64_t left_out() const { return left_out_; }

  void on_odometry(const lcm::ReceiveBuffer*, const std::string&, const odometry_t* m) {
    last_received_ns_ = monotonic_ns();
    // A source that began anew, and every discontinuity, goes out at once.
    const bool due = !last_ || m->utime < last_->utime || m->reset_counter != last_->reset_counter ||
                     m->utime - last_->utime >= period_us_ - period_us_ / 10;
    if (!due) return;
    last_ = Last{m->utime, m->reset_counter};
    if (arguments_.messages != "vision") send(sender_.odometry(mavlink_odometry(*m)));
    if (arguments_.messages != "odometry") send(sender_.vision_position(mavlink_vision_position(*m)));
  }

  void take_input() {
    const auto bytes = link_.receive();
    if (!bytes) {
      failure_ = bytes.error();
      return;
    }
    receiver_.add(*bytes, [this](const mavlink::TimeSync& m) {
      if (m.tc1 == 0) send(sender_.timesync({utc_now_ns(), m.ts1}));  // a question: what time is it here
    });
  }

  // Once a second.
  void beat() {
    constexpr std::int64_t kSecond = 1'000'000'000;
    const std::int64_t now_ns = monotonic_ns();
    if (auto ok = link_.flush(); !ok) failure_ = ok.error();
    if (now_ns < next_beat_ns_) return;
    next_beat_ns_ = now_ns + kSecond;
    const bool active = last_received_ns_ > 0 && now_ns - last_received_ns_ < kSecond;
    send(sender_.heartbeat(active));
  }

 private:
  struct Last {
    std::int64_t utime;
    std::int32_t reset_counter;
  };
  void send(const std::vector<std::uint8_t>& frame) {
    const auto done = link_.send(frame);
    if (!done) {
      failure_ = done.error();
    } else {
      ++(*done ? sent_ : left_out_);
    }
  }

  const MavlinkArguments& arguments_;
  MavlinkLink link_;
  mavlink::Sender sender_;
  mavlink::Receiver receiver_;
  std::int64_t period_us_;
  std::optional<Last> last_;
  std::int64_t last_received_ns_ = 0;
  std::int64_t next_beat_ns_ = 0;
  std::int64_t sent_ = 0;
  std::int64_t left_out_ = 0;
  std::optional<Error> failure_;
};

int run(const MavlinkArguments& arguments) {
  if (auto ok = daemon::check_lcm_url(arguments.lcm_url); !ok) return report(ok.error());
  auto link = MavlinkLink::open(arguments.to);
  if (!link) return report(link.error(), link.error().what == "wrong usage" ? kWrongUsage : kBadInput);
  lcm::LCM lcm(arguments.lcm_url);
  if (!lcm.good()) return report({"cannot receive over LCM", arguments.lcm_url, "see that its network is up"});
  Bridge bridge(arguments, std::move(*link));
  lcm.subscribe(arguments.channel, &Bridge::on_odometry, &bridge);
  const StopOnSignal signals;
  fmt::print("{} of {} to {} as {}.{}\n", arguments.channel, arguments.lcm_url, arguments.to, arguments.system,
             arguments.component);
  std::fflush(stdout);
  while (!StopOnSignal::received() && !bridge.failure()) {
    pollfd ready[2] = {{lcm.getFileno(), POLLIN, 0},
                       {bridge.descriptor(), static_cast<short>(bridge.has_pending() ? POLLIN | POLLOUT : POLLIN), 0}};
    if (::poll(ready, 2, 100) < 0 && errno != EINTR) return report({"cannot wait for messages", "poll", "try again"});
    if ((ready[0].revents & POLLIN) != 0) lcm.handle();
    if (ready[1].revents != 0) bridge.take_input();
    bridge.beat();
  }
  fmt::print("{} messages sent, {} left out\n", bridge.sent(), bridge.left_out());
  return bridge.failure() ? report(*bridge.failure()) : int{kDone};
}

}  // namespace

void add_mavlink_command(CliCommand app, int& exit_code) {
  auto arguments = std::make_shared<MavlinkArguments>();
  const CliCommand command = app.add_subcommand("mavlink", "Send the running daemon's odometry to an autopilot");
  command.add_option("--to", arguments->to, "Where: udp:HOST:PORT or serial:DEVICE[:BAUD] (default 921600)")
      .required()
      .type_name("LINK");
  command.add_option("--lcm", arguments->lcm_url, "Where the daemon publishes").type_name("URL");
  command.add_option("--channel", arguments->channel, "Its odometry's channel (default VO_ODOMETRY)").type_name("NAME");
  command
      .add_option("--messages", arguments->messages,
                  "odometry (ODOMETRY, default), vision (VISION_POSITION_ESTIMATE, for older firmware), or both")
      .one_of({"odometry", "vision", "both"})
      .type_name("NAME");
  command.add_option("--rate", arguments->rate_hz, "Most messages a second (default 50)")
      .between(0.1, 1000.0)
      .type_name("HZ");
  command.add_option("--system", arguments->system, "System id (default 1: the autopilot's own)")
      .between(1, 255)
      .type_name("ID");
  command.add_option("--component", arguments->component, "Component id (default 197: visual inertial odometry)")
      .between(1, 255)
      .type_name("ID");
  command.footer(
      "MAVLink 2; frames LOCAL_FRD and BODY_FRD, covariances, reset counter, quality -1 for a guess. A heartbeat a\n"
      "second; TIMESYNC is answered with this machine's UTC, by which the messages are stamped.\n"
      "Examples:\n"
      "  cliquevo mavlink --to udp:127.0.0.1:14540\n"
      "  cliquevo mavlink --to serial:/dev/ttyAMA0:921600 --rate 30");
  command.callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace cliquevo::tools
