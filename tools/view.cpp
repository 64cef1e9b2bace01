// SPDX-License-Identifier: BSD-3-Clause
// cliquevo view: what is seen, live and afterwards, in a browser.
#include "tools/view/view.h"

#include <cstdio>
#include <memory>
#include <string>

#include <fmt/format.h>

#include "daemon/pipeline/command_line.h"
#include "tools/commands.h"
#include "tools/exit_code.h"
#include "tools/reference.h"
#include "tools/reference_source.h"
#include "tools/source_argument.h"
#include "tools/stop_on_signal.h"
#include "tools/view/pipeline_feed.h"

namespace cliquevo::tools {

namespace {

struct ViewArguments {
  SourceArgument source;
  daemon::ConfigArgument config;
  std::string lcm_url;
  std::string reference;
  view::ViewOptions options;
};

// The source with the reference asked for, or with the one that the recording brings along: that cannot fail the view.
// A stamped one that lies there may be of another sensor, with other axes: it is taken when it is asked for.
Result<std::unique_ptr<drivers::FrameSource>> open_referenced(const ViewArguments& arguments,
                                                              const daemon::Config& config) {
  auto source = open_source(arguments.source, config.source);
  if (!source) return source.error();
  const bool asked = !arguments.reference.empty();
  if (!asked && is_simulator(arguments.source.text)) return source;
  const std::string file = asked ? arguments.reference : reference_beside(arguments.source.text);
  if (file.empty()) return source;
  auto reference = read_reference(file, &(*source)->info().calibration);
  if (!reference && asked) return reference.error();
  const bool may_be_turned = reference && reference->format == daemon::TrajectoryFormat::tum && !reference->of_body;
  if (!reference || (may_be_turned && !asked)) return source;
  return with_reference(std::move(*source), std::move(*reference));
}

Result<std::unique_ptr<view::Feed>> open_feed(const ViewArguments& arguments, const daemon::Config& config) {
  if (!arguments.lcm_url.empty()) return view::open_lcm_feed(arguments.lcm_url, config.T_body_camera);
  auto source = open_referenced(arguments, config);
  if (!source) return source.error();
  auto pipeline = daemon::FramePipeline::make({config.stereo, config.odometry, config.rectify}, (*source)->info());
  if (!pipeline) return pipeline.error();
  // Where the configuration says how the camera sits, that; else what the source knows.
  const daemon::Mounting& body = config.body;
  const bool given =
      body.translation_m != Eigen::Vector3d::Zero() || body.roll_pitch_yaw_deg != Eigen::Vector3d::Zero();
  const auto T_body_camera = given ? std::optional(config.T_body_camera) : (*source)->info().T_body_camera;
  return view::make_pipeline_feed(std::move(*source), std::move(*pipeline), T_body_camera);
}

int run(ViewArguments& arguments) {
  const bool both = !arguments.source.text.empty() && !arguments.lcm_url.empty();
  if (both) return report({"wrong usage", "cliquevo view", "give SOURCE or --lcm, not both"}, kWrongUsage);
  const auto read = daemon::read_config(arguments.config);
  if (!read) return report(read.error());
  const daemon::Config& config = *read;
  if (arguments.source.text.empty()) {
    if (arguments.lcm_url.empty()) arguments.lcm_url = config.lcm.url;
    if (arguments.options.control_socket.empty()) arguments.options.control_socket = config.control.socket;
    if (!arguments.reference.empty()) {
      return report({"wrong usage", "cliquevo view", "--reference goes with SOURCE"}, kWrongUsage);
    }
  } else if (auto usable = check_source(arguments.source); !usable) {
    return report(usable.error(), kWrongUsage);
  }
  auto feed = open_feed(arguments, config);
  if (!feed) return report(feed.error());
  const StopOnSignal signals;
  const auto announce = [](const std::string& address) {
    fmt::print("{}\n", address);
    std::fflush(stdout);
  };
  const auto done = run_view(std::move(*feed), arguments.options, announce, [] { return StopOnSignal::received(); });
  return done ? kDone : report(done.error());
}

}  // namespace

void add_view_command(CliCommand app, int& exit_code, const std::string& version) {
  auto arguments = std::make_shared<ViewArguments>();
  arguments->options.version = version;
  const CliCommand command = app.add_subcommand("view", kViewPurpose);
  command.add_option(
      "SOURCE", arguments->source.text,
      "A recording, an LCM log, sim or sim:key=value,... as replay takes them; none: the running daemon");
  command
      .add_option("--lcm", arguments->lcm_url, "Look at the daemon that sends here (default: the configuration's URL)")
      .type_name("URL");
  daemon::add_config_options(command, arguments->config, "Configuration (cliquevo config sample prints every key)");
  add_calibration_options(command, arguments->source);
  add_recording_options(command, arguments->source);
  command
      .add_option(
          "--reference", arguments->reference,
          "Trajectory to draw beside the way: of the left camera (KITTI, TUM), or EuRoC's or KITTI-360's ground "
          "truth (default: poses.txt and the like in the recording)")
      .type_name("FILE");
  auto& server = arguments->options.server;
  command.add_option("--port", server.port, "Port of the page, 0 = any that is free")
      .capture_default_str()
      .type_name("N");
  command
      .add_option(
          "--listen", server.listen,
          "Address to serve at. Another than loopback can be reached by others: the address printed then holds a "
          "token, without which nothing is served")
      .capture_default_str()
      .type_name("ADDR");
  command
      .add_option("--allow-origin", server.viewer_origins,
                  "Whose pages may connect as a viewer (foxglove.websocket.v1), e.g. http://localhost:8080; again for "
                  "more")
      .type_name("ORIGIN")
      .one_value_each_time();
  command.add_option("--keep-mb", arguments->options.keep_mb, "Most of pictures kept, in a file in TMPDIR (/var/tmp)")
      .between(std::int64_t{64}, std::int64_t{1} << 20)
      .capture_default_str()
      .type_name("MB");
  command
      .add_option("--socket", arguments->options.control_socket,
                  "The daemon's control.socket: with it the page can start and stop recording")
      .type_name("PATH");
  command.add_flag("--open", arguments->options.open_browser, "Open the page in the browser");
  command.footer(
      "Prints the page's address and serves until Ctrl-C. Of a daemon it shows what is sent: pictures, features and\n"
      "movers where lcm.images_channel, lcm.features_channel and lcm.movers_channel name VO_IMAGES, VO_FEATURES and\n"
      "VO_MOVERS.\n"
      "Viewers that speak foxglove.websocket.v1 (Foxglove, Lichtblick) connect to the same port: ws://127.0.0.1:8470.\n"
      "Examples:\n"
      "  cliquevo view sim:frames=300,movers=3 --open\n"
      "  cliquevo view /data/drive_0027\n"
      "  cliquevo view --lcm 'udpm://239.255.76.67:7667?ttl=0'");
  command.callback([arguments, &exit_code] { exit_code = run(*arguments); });
}

}  // namespace cliquevo::tools
