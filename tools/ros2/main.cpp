// SPDX-License-Identifier: BSD-3-Clause
// `cliquevo ros2` runs this: the running daemon's messages to ROS 2, which need not be installed.
#include <cerrno>
#include <memory>
#include <poll.h>
#include <string>
#include <utility>

#include <CLI/CLI.hpp>
#include <fmt/format.h>
#include <lcm/lcm-cpp.hpp>

#include "core/base/caught.h"
#include "daemon/lcm/lcm_url.h"
#include "daemon/lcm/message_sizes.h"
#include "daemon/pipeline/config.h"
#include "tools/exit_code.h"
#include "tools/help_format.h"
#include "tools/ros2/bridge.h"
#include "tools/stop_on_signal.h"

namespace {

using namespace cliquevo;
using namespace cliquevo::tools;

struct Arguments {
  std::string config;
  std::string lcm_url;
  std::string odometry_channel;
  std::string images_channel;
  std::string points_channel;
  ros2::BridgeOptions bridge;
};

class Handlers {
 public:
  explicit Handlers(ros2::Bridge& bridge) : bridge_(bridge) {}
  void on_odometry(const lcm::ReceiveBuffer* buffer, const std::string&) {
    if (publish<odometry_t>(*buffer)) ++count_;
  }
  void on_images(const lcm::ReceiveBuffer* buffer, const std::string&) { publish<images_t>(*buffer); }
  void on_points(const lcm::ReceiveBuffer* buffer, const std::string&) { publish<points_t>(*buffer); }
  long long count() const { return count_; }

 private:
  // A message of another type or a damaged one is left out.
  template <typename Message>
  bool publish(const lcm::ReceiveBuffer& buffer) {
    Message message;
    if (!daemon::decode_checked(buffer.data, buffer.data_size, message)) return false;
    bridge_.publish(message);
    return true;
  }

  ros2::Bridge& bridge_;
  long long count_ = 0;
};

int run(Arguments arguments) {
  daemon::Config config = daemon::default_config();
  if (!arguments.config.empty()) {
    auto read = daemon::read_config(arguments.config);
    if (!read) return report(read.error());
    config = std::move(*read);
  }
  if (arguments.lcm_url.empty()) arguments.lcm_url = config.lcm.url;
  if (arguments.odometry_channel.empty()) arguments.odometry_channel = config.lcm.odometry_channel;
  arguments.images_channel = config.lcm.images_channel.empty() ? "VO_IMAGES" : config.lcm.images_channel;
  arguments.points_channel = config.lcm.points_channel.empty() ? "VO_POINTS" : config.lcm.points_channel;
  arguments.bridge.T_body_camera = config.T_body_camera;
  if (auto ok = daemon::check_lcm_url(arguments.lcm_url); !ok) return report(ok.error());
  auto bridge = ros2::Bridge::start(arguments.bridge);
  if (!bridge) return report(bridge.error());
  lcm::LCM lcm(arguments.lcm_url);
  if (!lcm.good()) return report({"cannot receive over LCM", arguments.lcm_url, "see that its network is up"});
  Handlers handlers(*bridge);
  lcm.subscribe(arguments.odometry_channel, &Handlers::on_odometry, &handlers);
  if (arguments.bridge.images) lcm.subscribe(arguments.images_channel, &Handlers::on_images, &handlers);
  if (arguments.bridge.points) lcm.subscribe(arguments.points_channel, &Handlers::on_points, &handlers);
  const StopOnSignal signals;
  fmt::print("{} of {} to ROS 2, domain {}\n", arguments.odometry_channel, arguments.lcm_url, arguments.bridge.domain);
  std::fflush(stdout);
  while (!StopOnSignal::received()) {
    pollfd ready{lcm.getFileno(), POLLIN, 0};
    if (::poll(&ready, 1, 100) < 0 && errno != EINTR) return report({"cannot wait for messages", "poll", "try again"});
    if ((ready.revents & POLLIN) != 0) lcm.handle();
  }
  fmt::print("{} poses published\n", handlers.count());
  return kDone;
}

int parse_and_run(int argc, char** argv) {
  Arguments arguments;
  CLI::App app("Publish the running daemon's odometry for ROS 2: /odom, /tf, /tf_static, /diagnostics.",
               "cliquevo ros2");
  app.formatter(std::make_shared<HelpFormat>());
  app.add_option("--config", arguments.config, "The daemon's configuration: LCM, and where the camera sits")
      ->type_name("FILE");
  app.add_option("--lcm", arguments.lcm_url, "Where the daemon publishes (default: the configuration's)")
      ->type_name("URL");
  app.add_option("--domain", arguments.bridge.domain, "DDS domain (default: ROS_DOMAIN_ID, else 0)")
      ->envname("ROS_DOMAIN_ID")
      ->check(CLI::Range(0, 232))
      ->type_name("N");
  app.add_flag("--images", arguments.bridge.images,
               "/stereo/left/image_rect and /stereo/disparity too, of VO_IMAGES (lcm.images_channel)");
  app.add_flag("--points", arguments.bridge.points, "/stereo/points2 too, of VO_POINTS (lcm.points_channel)");
  app.footer(
      "Frames: odom, base_link, camera_left_optical_frame. CYCLONEDDS_URI chooses the network, as for ROS 2 itself.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& wanted) {
    return app.exit(wanted);
  } catch (const CLI::ParseError& error) {
    return report({"wrong usage", "ros2", std::string(error.what()) + " (see cliquevo ros2 --help)"}, kWrongUsage);
  }
  return run(std::move(arguments));
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return parse_and_run(argc, argv);
  } catch (...) {
    return report(caught("cliquevo ros2"));
  }
}
