// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/output.h"

#include <utility>

#include <spdlog/spdlog.h>

namespace cliquevo::daemon {

Result<std::unique_ptr<Output>> Output::make(Publisher publisher, const Config& config, const StereoModel& model,
                                             ImageView<const std::uint8_t> mask, const std::string& trajectory) {
  const double images_rate_hz = config.lcm.images_channel.empty() ? 0.0 : config.lcm.images_rate_hz;
  auto points = PointsThread::start(config.lcm, model, config.T_body_camera);
  if (!points) return points.error();
  std::unique_ptr<Output> out(
      new Output{std::move(publisher),
                 ImageTap({model.width, model.height, images_rate_hz, config.lcm.images_right, mask}),
                 {!config.lcm.features_channel.empty(), static_cast<std::size_t>(config.odometry.max_features)},
                 std::move(*points),
                 model,
                 std::nullopt,
                 {},
                 {}});
  if (trajectory.empty()) return out;
  auto sink = TrajectorySink::open(trajectory);
  if (!sink) return sink.error();
  out->trajectory.emplace(std::move(*sink));
  return out;
}

void Output::take(const PublishedFrame& frame) {
  bool taken = publisher.publish(frame);
  if (const TappedFeatures* features = feature_tap.take()) {
    taken = publisher.publish(*features, model) && taken;
    feature_tap.give_back();
  }
  if (const TappedImages* images = tap.take()) {  // after the pose: nobody steers by a picture
    taken = publisher.publish(*images, model) && taken;
    tap.give_back();
  }
  if (points) taken = points->after_frame(publisher) && taken;
  if (!taken && sent.send_errors.fetch_add(1, std::memory_order_relaxed) == 0) {
    spdlog::warn("LCM does not take messages: further ones are only counted");
  }
  diagnostics.take(frame.estimate);
  if (frame.estimate.status == vo::Status::valid) sent.valid.fetch_add(1, std::memory_order_relaxed);
  if (trajectory) trajectory->append(frame.estimate.stamp_ns, frame.estimate.T_world_camera);
}

}  // namespace cliquevo::daemon
