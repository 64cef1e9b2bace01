// SPDX-License-Identifier: BSD-3-Clause
// A daemon's messages, put together frame by frame. It only listens.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <list>
#include <map>
#include <mutex>
#include <utility>
#include <zlib.h>

#include <cliquevo/features_t.hpp>
#include <cliquevo/health_t.hpp>
#include <cliquevo/images_t.hpp>
#include <cliquevo/movers_t.hpp>
#include <cliquevo/odometry_t.hpp>
#include <cliquevo/points_t.hpp>
#include <cliquevo/pose_t.hpp>
#include <cliquevo/status_t.hpp>
#include <cliquevo/update_t.hpp>
#include <lcm/lcm-cpp.hpp>

#include "core/base/caught.h"
#include "core/base/time.h"
#include "daemon/lcm/lcm_url.h"
#include "daemon/lcm/message_sizes.h"
#include "daemon/lcm/status_report.h"
#include "tools/view/feed.h"
#include "tools/view/ros2_writer.h"

namespace cliquevo::view {

namespace {

constexpr std::size_t kMostPending = 16;
constexpr int kMostWaiting = 60;       // messages of a channel, where this process is late: two seconds
constexpr int kMostWaitingImages = 3;  // these are large, and an old one is of no use
constexpr std::size_t kPointsOfAFrame = 10;
constexpr int kMostFeatures = 20'000;
constexpr std::int64_t kMostPixels = 64'000'000;

RigidTransform transform(const double (&t)[3], const double (&q)[4]) {
  RigidTransform out;
  const Eigen::Quaterniond rotation(q[0], q[1], q[2], q[3]);
  if (!(std::abs(rotation.norm() - 1.0) < 1e-3)) return out;
  out.R = rotation.normalized().toRotationMatrix();
  out.t = {t[0], t[1], t[2]};
  return out.is_finite() ? out : RigidTransform{};
}

// Pictures come in many packets at once: room for them, where the system grants it (net.core.rmem_max).
std::string with_room(const std::string& url) {
  if (!url.starts_with("udpm:") || url.find("recv_buf_size") != std::string::npos) return url;
  return url + (url.find('?') == std::string::npos ? '?' : '&') + "recv_buf_size=4194304";
}

// Whether it can be had in ns.
bool is_time(std::int64_t utime) { return utime >= 0 && utime <= std::numeric_limits<std::int64_t>::max() / 1000; }

// Messages of one frame.
struct Pending {
  std::optional<update_t> delta;
  std::optional<pose_t> pose;
  std::optional<status_t> status;
  std::optional<movers_t> movers;
  std::optional<features_t> features;
};

MoverFact fact_of(const mover_t& m) {
  MoverFact out;
  out.id = m.id;
  out.of_vehicle = m.of_vehicle != 0;
  out.centre_m = {m.centre[0], m.centre[1], m.centre[2]};
  out.speed_m_s = std::hypot(m.velocity[0], m.velocity[1], m.velocity[2]);
  for (std::size_t i = 0; i < m.pixel.size(); ++i) {
    if (m.pixel[i].size() != 2) continue;
    const double x = m.pixel[i][0];
    const double y = m.pixel[i][1];
    out.left_px = i == 0 ? x : std::min(out.left_px, x);
    out.top_px = i == 0 ? y : std::min(out.top_px, y);
    out.right_px = i == 0 ? x : std::max(out.right_px, x);
    out.bottom_px = i == 0 ? y : std::max(out.bottom_px, y);
  }
  return out;
}

std::vector<vo::SeenFeature> features_of(const features_t& m) {
  std::vector<vo::SeenFeature> out;
  if (m.num_features > kMostFeatures) return out;
  for (std::size_t i = 0; i < m.x.size(); ++i) {
    const int role = std::clamp<int>(m.role[i], 0, features_t::CORNER);
    out.push_back(
        {m.x[i], m.y[i], m.from_x[i], m.from_y[i], m.disparity[i], m.error[i], static_cast<vo::FeatureRole>(role)});
  }
  return out;
}

StereoModel model_of(const features_t& m) {
  return {m.width, m.height, m.fx_px, m.fy_px, m.cx_px, m.cy_px, m.baseline_m, m.doffs_px};
}

// The members of VO_STATUS.
void take_status(const status_t& s, FrameFacts& out) {
  out.index = s.frame;
  out.status = s.status;
  out.quality = s.quality;
  out.features = s.features;
  out.matches = s.matches;
  out.clique = s.clique;
  out.inliers = s.inliers;
  out.error_px = s.reprojection_error_px;
  out.expected_error_px = s.expected_error_px;
  out.shift_px = s.disparity_shift_px;
  out.disparity_offset_px = s.disparity_offset_px;
  out.disparity_offset_sigma_px = s.disparity_offset_sigma_px;
  out.vertical_px = s.vertical_px;
  out.vertical_sigma_px = s.vertical_sigma_px;
  for (std::size_t k = 0; k < std::min(out.checks.size(), s.check_ratio.size()); ++k) {
    out.checks[k].ratio = s.check_ratio[k];
  }
  out.failed = static_cast<std::uint32_t>(s.checks_failed);
  out.times = {
      s.rectify_us, s.stereo_us, s.odometry_us, {s.features_us, s.scores_us, s.matches_us, s.clique_us, s.motion_us}};
  if (s.grabbed_utime > 0) out.latency_us = s.publish_utime - s.grabbed_utime;
}

void take_checks(const features_t& m, FrameFacts& out) {
  for (std::size_t k = 0; k < std::min({out.checks.size(), m.check_value.size(), m.check_bound.size()}); ++k) {
    if (m.check_value[k] == 0.0 && m.check_bound[k] == 0.0) continue;
    out.checks[k].value = m.check_value[k];
    out.checks[k].bound = m.check_bound[k];
  }
}

// Whether the image's bytes are as many as its size says.
bool holds(const image_t& image, int bytes_a_pixel) {
  const std::int64_t row = static_cast<std::int64_t>(image.width) * bytes_a_pixel;
  return image.width > 0 && image.height > 0 && row * image.height <= kMostPixels && image.row_stride >= row &&
         static_cast<std::int64_t>(image.row_stride) * image.height <= static_cast<std::int64_t>(image.data.size());
}

class LcmFeed final : public Feed {
 public:
  LcmFeed(const std::string& url, const RigidTransform& T_body_camera)
      : url_(url), lcm_(with_room(url)), T_body_camera_of_config_(T_body_camera) {
    subscribe<update_t>("VO_DELTA_CAMERA", [this](const update_t& m) { pending(m.timestamp).delta = m; });
    subscribe<pose_t>("POSE_BODY", [this](const pose_t& m) { pending(m.utime).pose = m; });
    subscribe<status_t>("VO_STATUS", [this](const status_t& m) { pending(m.utime).status = m; });
    subscribe<movers_t>("VO_MOVERS", [this](const movers_t& m) { pending(m.utime).movers = m; });
    subscribe<features_t>("VO_FEATURES", [this](const features_t& m) { pending(m.utime).features = m; });
    subscribe<odometry_t>("VO_ODOMETRY", [this](const odometry_t& m) {
      if (is_time(m.utime)) ros2_->add(m);
    });
    subscribe<points_t>("VO_POINTS", [this](const points_t& m) {
      if (is_time(m.utime)) ros2_->add(m);
    });
    subscribe<images_t>(
        "VO_IMAGES", [this](const images_t& m) { take_images(m); }, kMostWaitingImages);
    subscribe<health_t>("VO_HEALTH", [this](const health_t& m) { take_health(m); });
    state_.text = "no messages yet";
  }

  bool good() { return lcm_.good(); }
  bool live() const override { return true; }
  std::string source() const override { return url_; }
  FeedState state() const override {
    const std::lock_guard lock(mutex_);
    return state_;
  }

  void run(Store& store, Ros2Topics& topics, const std::function<bool()>& stopped) override {
    store_ = &store;
    ros2_.emplace(topics, T_body_camera_of_config_);
    while (!stopped()) {
      const int got = lcm_.handleTimeout(40);
      if (got == 0) commit_before(std::numeric_limits<std::int64_t>::max());
      if (got < 0) return fail("LCM does not receive any more; start again");
      const std::int64_t silent_ns = monotonic_ns() - last_message_ns_;
      const char* text = last_message_ns_ == 0 ? "no messages yet" : silent_ns > 3'000'000'000 ? "silent" : "live";
      const std::lock_guard lock(mutex_);
      state_.text = text;
    }
  }

 private:
  template <typename Message, typename Handler>
  void subscribe(const char* channel, Handler handler, int most_waiting = kMostWaiting) {
    std::function<void(const lcm::ReceiveBuffer*, const std::string&)> decode =
        [this, handler](const lcm::ReceiveBuffer* buffer, const std::string&) {
          // A message of another type or a damaged one is nobody's fault here.
          static_cast<void>(guarded("view", [&]() -> Result<void> {
            Message message;
            if (!daemon::decode_checked(buffer->data, buffer->data_size, message)) return {};
            last_message_ns_ = monotonic_ns();
            handler(message);
            return {};
          }));
        };
    handlers_.push_back(std::move(decode));
    lcm_.subscribeFunction(channel, &LcmFeed::call, &handlers_.back())->setQueueCapacity(most_waiting);
  }
  static void call(const lcm::ReceiveBuffer* buffer, const std::string& channel,
                   std::function<void(const lcm::ReceiveBuffer*, const std::string&)>* handler) {
    (*handler)(buffer, channel);
  }

  // The frame of that time; whatever is older is complete, as messages of a frame come together.
  Pending& pending(std::int64_t utime) {
    if (utime < last_committed_us_ - 1'000'000) restart();
    commit_before(utime);
    while (pending_.size() >= kMostPending) pending_.erase(pending_.begin());
    return pending_[utime];
  }

  void restart() {
    pending_.clear();
    ++epoch_;
    way_.restart();
    last_committed_us_ = 0;
  }

  void commit_before(std::int64_t utime) {
    while (!pending_.empty() && pending_.begin()->first < utime) {
      const auto [at, frame] = *pending_.begin();
      pending_.erase(pending_.begin());
      if (frame.status && frame.pose && at > last_committed_us_) commit(at, frame);
    }
  }

  void commit(std::int64_t utime, const Pending& frame) {
    const status_t& s = *frame.status;
    if (s.frame < last_frame_ || s.resets != last_resets_) {
      ++epoch_;
      way_.restart();
    }
    last_frame_ = s.frame;
    last_resets_ = s.resets;
    last_committed_us_ = utime;
    FrameFacts facts;
    facts.stamp_us = utime;
    facts.epoch = epoch_;
    take_status(s, facts);
    facts.T_world_body = transform(frame.pose->pos, frame.pose->orientation);
    const RigidTransform T_world_camera = facts.T_world_body * T_body_camera_;
    if (frame.delta) {
      Matrix6d covariance;
      for (int r = 0; r < 6; ++r) {
        for (int c = 0; c < 6; ++c) covariance(r, c) = frame.delta->covariance[r][c];
      }
      facts.step_sigma_m = std::sqrt(std::max(0.0, covariance.topLeftCorner<3, 3>().trace()));
      facts.position_m2 = way_.add(s.status == status_t::VALID, T_world_camera, covariance);
    }
    FrameParts parts;
    if (early_pictures_.first == utime) parts = std::exchange(early_pictures_, {}).second;
    if (frame.movers) {
      for (const mover_t& m : frame.movers->movers) facts.movers.push_back(fact_of(m));
    }
    if (frame.features) take_features(*frame.features, facts, parts);
    store_->add(facts, parts);
  }

  void take_features(const features_t& m, FrameFacts& facts, FrameParts& parts) {
    const StereoModel model = model_of(m);
    const auto features = features_of(m);
    parts.features = pack_features(features);
    take_checks(m, facts);
    if (!model.check()) return;
    T_body_camera_ = transform(m.camera_translation, m.camera_rotation);
    ros2_->mount(T_body_camera_);
    if (count_++ % 3 == 0 && facts.status == status_t::VALID) {
      facts.points = some_points(features, kPointsOfAFrame, model, facts.T_world_body * T_body_camera_);
    }
    const RigidTransform untold = forward_left_up();
    const std::lock_guard lock(mutex_);
    state_.model = model;
    state_.level = (T_body_camera_.R - untold.R).norm() > 1e-6 || T_body_camera_.t != untold.t;
  }

  void take_images(const images_t& m) {
    if (!is_time(m.utime)) return;
    FrameParts parts;
    for (std::size_t i = 0; i < std::min(m.images.size(), m.image_types.size()); ++i) {
      const image_t& image = m.images[i];
      const std::int16_t type = m.image_types[i];
      if (type == images_t::MASK_ZIPPED) {
        take_mask(image);
      } else if (!holds(image, type == images_t::DISPARITY ? 2 : 1)) {
        continue;
      } else if (type == images_t::LEFT || type == images_t::RIGHT) {
        const ImageView<const std::uint8_t> view{image.data.data(), image.width, image.height, image.row_stride};
        (type == images_t::LEFT ? parts.left : parts.right) = jpeg_.encode(view, kJpegQuality);
        if (type == images_t::LEFT) ros2_->add_left(m.utime * 1000, view, camera_of(image));
      } else if (type == images_t::DISPARITY && image.row_stride % 2 == 0) {
        take_disparity(image, parts);
        ros2_->add_disparity(m.utime * 1000, disparity_.cview());
      }
    }
    commit_before(m.utime + 1);
    if (!store_->add_pictures(m.utime, parts)) early_pictures_ = {m.utime, std::move(parts)};
  }

  void take_disparity(const image_t& image, FrameParts& parts) {
    disparity_.resize(image.width, image.height);
    for (int y = 0; y < image.height; ++y) {
      std::memcpy(disparity_.view().row(y), image.data.data() + static_cast<std::size_t>(y) * image.row_stride,
                  2 * static_cast<std::size_t>(image.width));
    }
    DisparityPicture picture = encode_disparity(disparity_.cview());
    parts.disparity = std::move(picture.png);
    parts.disparity_step_px = picture.step_px;
  }

  // It comes with every picture and hardly ever changes.
  void take_mask(const image_t& image) {
    if (image.data == zipped_mask_ || image.width <= 0 || image.height <= 0) return;
    if (static_cast<std::int64_t>(image.width) * image.height > kMostPixels) return;
    zipped_mask_ = image.data;
    std::vector<std::uint8_t> rows(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height));
    uLongf size = rows.size();
    if (uncompress(rows.data(), &size, image.data.data(), image.data.size()) != Z_OK || size != rows.size()) return;
    auto jpeg = jpeg_.encode({rows.data(), image.width, image.height, image.width}, kMaskQuality);
    const std::lock_guard lock(mutex_);
    state_.mask = std::make_shared<const Bytes>(std::move(jpeg));
  }

  void take_health(const health_t& m) {
    const std::lock_guard lock(mutex_);
    state_.health_json = daemon::status_json(m, "");
    state_.check_text = m.calibration_text;
    state_.view_text = m.view_text;
  }

  void fail(const std::string& error) {
    const std::lock_guard lock(mutex_);
    state_.done = true;
    state_.error = error;
  }

  const std::string url_;
  lcm::LCM lcm_;
  std::list<std::function<void(const lcm::ReceiveBuffer*, const std::string&)>> handlers_;
  Store* store_ = nullptr;
  const RigidTransform T_body_camera_of_config_;
  std::optional<Ros2Writer> ros2_;  // once it runs
  std::map<std::int64_t, Pending> pending_;
  std::int64_t last_committed_us_ = 0;
  std::int64_t last_frame_ = -1;
  std::int32_t last_resets_ = 0;
  std::int32_t epoch_ = 0;
  std::int64_t count_ = 0;
  std::int64_t last_message_ns_ = 0;
  RigidTransform T_body_camera_ = forward_left_up();
  WayUncertainty way_;
  JpegEncoder jpeg_;
  Image<std::int16_t> disparity_;
  std::vector<std::uint8_t> zipped_mask_;
  std::pair<std::int64_t, FrameParts> early_pictures_;  // that came before their frame's other messages
  mutable std::mutex mutex_;
  FeedState state_;
};

}  // namespace

Result<std::unique_ptr<Feed>> open_lcm_feed(const std::string& url, const RigidTransform& T_body_camera) {
  if (auto ok = daemon::check_lcm_url(url); !ok) return ok.error();
  auto feed = std::make_unique<LcmFeed>(url, T_body_camera);
  if (!feed->good()) return Error{"cannot receive LCM messages", url, "check the URL and the route"};
  return std::unique_ptr<Feed>(std::move(feed));
}

}  // namespace cliquevo::view
