// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/lcm/publisher.h"

#include <utility>
#include <vector>

#include <cliquevo/features_t.hpp>
#include <cliquevo/images_t.hpp>
#include <cliquevo/movers_t.hpp>

#include "core/base/clock.h"
#include "daemon/lcm/message_sender.h"
#include "daemon/lcm/messages.h"

namespace cliquevo::daemon {

namespace {

// One message type on one channel, encoded into a buffer that is kept: lcm::LCM::publish(channel, &message) would
// allocate one a message.
template <typename Message>
class Channel {
 public:
  explicit Channel(std::string name) : name_(std::move(name)) {}

  bool on() const { return !name_.empty(); }

  // true also for a channel without a name: it is switched off.
  bool send(MessageSender& sender, const Publisher::Copy& copy, const Message& message) {
    if (name_.empty()) return true;
    const auto size = static_cast<std::size_t>(message.getEncodedSize());
    if (buffer_.size() < size) buffer_.resize(size);
    const int used = message.encode(buffer_.data(), 0, static_cast<int>(size));
    if (used >= 0 && copy) copy(name_, buffer_.data(), static_cast<std::size_t>(used));
    return used >= 0 && sender.send(name_, buffer_.data(), static_cast<std::size_t>(used));
  }

 private:
  std::string name_;
  std::vector<std::uint8_t> buffer_;
};

Result<void> check_channels(const LcmConfig& config) {
  for (const LcmChannel& channel : kLcmChannels) {
    const std::string& name = config.*channel.name;
    if (name.size() <= kLongestChannel && !(channel.required && name.empty())) continue;
    return Error{"unusable LCM channel name", std::string("lcm.") + channel.key + " = '" + name + "'",
                 "use 1 to 63 characters"};
  }
  return {};
}

}  // namespace

struct Publisher::Impl {
  Impl(std::unique_ptr<MessageSender> sender_, const LcmConfig& config, const RigidTransform& T_body_camera_)
      : sender(std::move(sender_)),
        T_body_camera(T_body_camera_),
        builder(T_body_camera_),
        delta(config.delta_channel),
        pose(config.pose_channel),
        status(config.status_channel),
        odometry(config.odometry_channel),
        delta_body(config.delta_body_channel),
        movers(config.movers_channel),
        features(config.features_channel),
        images(config.images_channel),
        health(config.health_channel) {}

  std::unique_ptr<MessageSender> sender;
  Copy copy;
  RigidTransform T_body_camera;
  MessageBuilder builder;
  FrameMessages messages;
  Channel<update_t> delta;
  Channel<pose_t> pose;
  Channel<status_t> status;
  Channel<odometry_t> odometry;
  Channel<update_t> delta_body;
  Channel<movers_t> movers;
  movers_t movers_message{};
  Channel<features_t> features;
  features_t features_message{};
  Channel<images_t> images;
  images_t images_message;
  Channel<health_t> health;
};

Result<Publisher> Publisher::make(const LcmConfig& config, const RigidTransform& T_body_camera) {
  if (const auto ok = check_channels(config); !ok) return ok.error();
  auto sender = MessageSender::open(config.url);
  if (!sender) return sender.error();
  return Publisher(std::make_unique<Impl>(std::move(*sender), config, T_body_camera));
}

Publisher::Publisher(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Publisher::Publisher(Publisher&&) noexcept = default;
Publisher& Publisher::operator=(Publisher&&) noexcept = default;
Publisher::~Publisher() = default;

void Publisher::copy_to(Copy copy) { impl_->copy = std::move(copy); }

bool Publisher::publish(const PublishedFrame& frame) {
  Impl& m = *impl_;
  m.builder.build(frame, utc_now_ns(), m.messages);
  // The delta first: estimators wait for it. Each is tried, whatever became of the one before.
  const bool delta_sent = m.delta.send(*m.sender, m.copy, m.messages.delta);
  const bool pose_sent = m.pose.send(*m.sender, m.copy, m.messages.pose);
  const bool status_sent = m.status.send(*m.sender, m.copy, m.messages.status);
  const bool odometry_sent = m.odometry.send(*m.sender, m.copy, m.messages.odometry);
  const bool delta_body_sent = m.delta_body.send(*m.sender, m.copy, m.messages.delta_body);
  if (m.movers.on()) build_movers(frame.movers, m.movers_message);
  const bool movers_sent = m.movers.send(*m.sender, m.copy, m.movers_message);
  return delta_sent && pose_sent && status_sent && odometry_sent && delta_body_sent && movers_sent;
}

bool Publisher::publish(const TappedImages& images, const StereoModel& model) {
  Impl& m = *impl_;
  build_images(images, model, m.images_message);
  return m.images.send(*m.sender, m.copy, m.images_message);
}

bool Publisher::publish(const TappedFeatures& features, const StereoModel& model) {
  Impl& m = *impl_;
  build_features(features, model, m.T_body_camera, m.features_message);
  return m.features.send(*m.sender, m.copy, m.features_message);
}

bool Publisher::pass_on(const std::string& channel, const std::uint8_t* data, std::size_t size, bool send) {
  if (impl_->copy) impl_->copy(channel, data, size);
  return !send || impl_->sender->send(channel, data, size);
}

bool Publisher::publish(const health_t& health) { return impl_->health.send(*impl_->sender, impl_->copy, health); }

}  // namespace cliquevo::daemon
