// SPDX-License-Identifier: BSD-3-Clause
// cliquevo hil: a recording or the simulator as two GigE Vision cameras.
#include "tools/hil.h"

#include <chrono>
#include <filesystem>
#include <memory>
#include <thread>

#include <fmt/format.h>

#include "tools/exit_code.h"
#include "tools/hil_cameras.h"
#include "tools/source_argument.h"
#include "tools/stop_on_signal.h"

namespace cliquevo::tools {

namespace {

struct HilArguments {
  SourceArgument source;
  HilOptions options;
  bool rate_given = false;
};

// What a configuration needs to use these cameras.
std::string config_lines(const HilArguments& a, const drivers::SourceInfo& info) {
  std::error_code ec;
  const std::string& file = info.calibration.source;
  const std::string calibration = std::filesystem::exists(file, ec) ? std::filesystem::absolute(file, ec).string() : "";
  return fmt::format(
      "source:\n  type: aravis\n  cameras:\n    left: \"{}\"\n    right: \"{}\"\n    calibration: \"{}\"\n"
      "    rate_hz: {:g}\n    exposure_us: 10000\n    gain: 0\n    shared_clock: true\n",
      a.options.left_serial, a.options.right_serial,
      calibration.empty() ? "(of the recording: name its file)" : calibration, a.options.rate_hz);
}

int run(HilArguments arguments) {
  if (auto usable = check_source(arguments.source); !usable) return report(usable.error(), kWrongUsage);
  auto source = open_source(arguments.source, daemon::default_config().source);
  if (!source) return report(source.error());
  const drivers::SourceInfo& info = (*source)->info();
  if (!arguments.rate_given && info.rate_hz > 0.0) arguments.options.rate_hz = info.rate_hz;
  auto cameras = HilCameras::start(**source, arguments.options);
  if (!cameras) return report(cameras.error());
  fmt::print("serving {} pairs of {}x{} at {:.2f} Hz; as configuration:\n{}READY\n", cameras->pairs(), info.width,
             info.height, arguments.options.rate_hz, config_lines(arguments, info));
  std::fflush(stdout);

  const StopOnSignal signals;
  const double outage_every_s = arguments.options.outage_every_s;
  std::int64_t since_ns = monotonic_ns();
  while (!StopOnSignal::received()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    if (outage_every_s <= 0.0 || static_cast<double>(monotonic_ns() - since_ns) * 1e-9 < outage_every_s) continue;
    fmt::print("both cameras are gone\n");
    std::fflush(stdout);
    cameras->unplug();
    std::this_thread::sleep_for(std::chrono::duration<double>(arguments.options.outage_s));
    if (auto ok = cameras->plug_in(); !ok) return report(ok.error());
    fmt::print("both cameras are back\n");
    std::fflush(stdout);
    since_ns = monotonic_ns();
  }
  const HilCounts counts = cameras->counts();
  fmt::print("sent {} frames of the left camera, {} of the right\n", counts.left, counts.right);
  return kDone;
}

}  // namespace

void add_hil_command(CliCommand app, int& exit_code) {
  auto arguments = std::make_shared<HilArguments>();
  HilOptions& options = arguments->options;
  const CliCommand hil =
      app.add_subcommand("hil", "Serve a recording as two GigE Vision cameras, over the real protocol");
  hil.add_option("SOURCE", arguments->source.text, "A recording (folder or log), sim, or sim:key=value,...").required();
  add_calibration_options(hil, arguments->source);
  hil.add_option_function<std::int64_t>(
         "--first", [arguments](const std::int64_t& i) { arguments->source.first = i; }, "First pair, counted from 0")
      .not_negative()
      .type_name("I");
  hil.add_option_function<std::int64_t>(
         "--last", [arguments](const std::int64_t& i) { arguments->source.last = i; }, "Last pair")
      .not_negative()
      .type_name("I");
  hil.add_option_function<double>(
         "--rate",
         [arguments](const double& rate_hz) {
           arguments->options.rate_hz = rate_hz;
           arguments->rate_given = true;
         },
         "Pairs a second (default: the recording's), until the receiver sets another")
      .between(0.1, 1000.0)
      .type_name("HZ");
  hil.add_option("--left-address", options.left_address, "Of an interface of this machine (default 127.0.0.1)")
      .type_name("IP");
  hil.add_option("--right-address", options.right_address, "Another one (default 127.0.0.2)").type_name("IP");
  hil.add_option("--left-serial", options.left_serial, "Serial number (default HIL-LEFT): two rigs need two each")
      .type_name("NAME");
  hil.add_option("--right-serial", options.right_serial, "Serial number (default HIL-RIGHT)").type_name("NAME");
  hil.add_flag("--pingpong", options.pingpong, "Forward, backward, forward ... without end");
  hil.add_option("--loss", options.loss, "Share of the packets that get lost").between(0.0, 1.0).type_name("SHARE");
  hil.add_option("--drop-every", options.drop_every, "Leave out every N-th frame of the right camera")
      .not_negative()
      .type_name("N");
  hil.add_option("--swap-every", options.swap_every, "Send every N-th frame of the right camera before its predecessor")
      .not_negative()
      .type_name("N");
  hil.add_option("--right-late", options.right_late_s, "Send the right camera's frames late, s")
      .between(0.0, 1.0)
      .type_name("S");
  hil.add_option("--log", options.log, "Write a line for each frame sent: stamp in us, L or R, number of the pair")
      .type_name("FILE");
  hil.add_option("--outage-every", options.outage_every_s, "Both cameras vanish every so many seconds ...")
      .not_negative()
      .type_name("S");
  hil.add_option("--outage", options.outage_s, "... for so long (default 2)").not_negative().type_name("S");
  hil.footer(
      "Frame 0 waits until both are streamed. Discovery answers on every interface: keep it to yourself with a\n"
      "network of its own:\n"
      "  unshare --net sh -c 'ip link set lo up; ip address add 127.0.0.2/8 dev lo; cliquevo hil sim & ...'");
  hil.callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace cliquevo::tools
