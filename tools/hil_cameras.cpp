// SPDX-License-Identifier: BSD-3-Clause
#include "tools/hil_cameras.h"

#include <algorithm>
#include <arv.h>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <mutex>
#include <thread>
#include <utility>

#include <fmt/format.h>

namespace cliquevo::tools {

namespace {

constexpr std::size_t kMostBytes = std::size_t{4} << 30;
constexpr std::int64_t kForgottenUs = 1'000'000;

struct Pixels {
  std::vector<std::uint8_t> left;
  std::vector<std::uint8_t> right;
};

std::vector<std::uint8_t> packed(const Image<std::uint8_t>& image) {
  std::vector<std::uint8_t> out;
  const ImageView<const std::uint8_t> view = image.cview();
  for (int y = 0; y < view.height; ++y) out.insert(out.end(), view.row(y), view.row(y) + view.width);
  return out;
}

}  // namespace

struct HilCameras::Impl {
  struct Side {
    Impl* rig = nullptr;
    bool is_left = true;
    ArvGvFakeCamera* camera = nullptr;
    std::int64_t last_us = 0;  // when a frame was last requested; under the mutex, as all that follows
    std::int64_t last_tick = 0;
    bool seen = false;
    std::int64_t sent = 0;
  };

  // What a camera does at one tick.
  struct Plan {
    bool send = false;
    std::int64_t frame = 0;
    std::int64_t stamp_us = 0;
  };

  ~Impl() { unplug(); }
  void unplug() {
    for (Side& side : sides) {
      if (side.camera != nullptr) g_object_unref(side.camera);
      side.camera = nullptr;
    }
  }
  Result<void> plug_in(Side& side);
  Plan plan(Side& side, std::int64_t period_us, bool triggered);
  void fill(Side& side, ArvBuffer* buffer);

  HilOptions options;
  std::ofstream log;
  int width = 0;
  int height = 0;
  std::vector<Pixels> pairs;
  Side sides[2];
  std::mutex mutex;
  std::int64_t start_tick = 0;  // of frame 0; 0 = waits for both cameras
  std::int64_t event = 0;       // of software triggers: the present exposure's number and time
  std::int64_t event_us = 0;
};

HilCameras::Impl::Plan HilCameras::Impl::plan(Side& side, std::int64_t period_us, bool triggered) {
  const std::lock_guard<std::mutex> lock(mutex);
  const std::int64_t now_us = g_get_real_time();
  std::int64_t tick = now_us / period_us;
  Plan out;
  out.stamp_us = tick * period_us;
  if (triggered) {  // two triggers close together are one exposure
    if (now_us - event_us > period_us / 2) {
      ++event;
      event_us = now_us;
    }
    tick = event;
    out.stamp_us = event_us;
  }
  if (side.last_us != 0 && now_us - side.last_us > kForgottenUs + period_us) {
    start_tick = 0;
    for (Side& each : sides) each.seen = false;
  }
  side.last_us = now_us;
  const bool again = tick == side.last_tick;
  side.last_tick = tick;
  side.seen = true;
  if (start_tick == 0 && sides[0].seen && sides[1].seen) start_tick = tick + 2;
  if (again || start_tick == 0 || tick < start_tick) return out;
  std::int64_t k = tick - start_tick;
  const auto count = static_cast<std::int64_t>(pairs.size());
  if (!options.pingpong && k >= count) return out;
  if (!side.is_left) {
    if (options.drop_every > 0 && k % options.drop_every == options.drop_every - 1) return out;
    const std::int64_t turn = options.swap_every;
    if (turn > 1 && k % turn >= turn - 2) {
      const std::int64_t by = k % turn == turn - 2 ? 1 : -1;
      if (options.pingpong || k + by < count) {
        k += by;
        out.stamp_us += by * period_us;
      }
    }
  }
  const std::int64_t round = std::max<std::int64_t>(1, 2 * (count - 1));
  out.frame = k % round < count ? k % round : round - k % round;
  out.send = true;
  ++side.sent;
  if (log) log << out.stamp_us << (side.is_left ? " L " : " R ") << out.frame << '\n' << std::flush;
  return out;
}

void HilCameras::Impl::fill(Side& side, ArvBuffer* buffer) {
  ArvFakeCamera* fake = arv_gv_fake_camera_get_fake_camera(side.camera);
  guint32 period_us = 0;
  arv_fake_camera_read_register(fake, ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US, &period_us);
  const bool triggered = arv_fake_camera_is_in_software_trigger_mode(fake) != 0;
  const Plan todo = plan(side, std::max<std::int64_t>(1, period_us), triggered);
  // A frame whose packets are all lost was never sent.
  g_object_set(side.camera, "gvsp-lost-ratio", todo.send ? options.loss : 1.0, nullptr);
  if (!todo.send) return;
  const Pixels& pair = pairs[static_cast<std::size_t>(todo.frame)];
  const std::vector<std::uint8_t>& pixels = side.is_left ? pair.left : pair.right;
  std::size_t ignored = 0;
  auto* to = const_cast<void*>(arv_buffer_get_data(buffer, &ignored));
  std::memcpy(to, pixels.data(), pixels.size());
  arv_buffer_set_timestamp(buffer, static_cast<guint64>(todo.stamp_us) * 1000U);
  if (!side.is_left && options.right_late_s > 0.0) {
    std::this_thread::sleep_for(std::chrono::duration<double>(options.right_late_s));
  }
}

Result<void> HilCameras::Impl::plug_in(Side& side) {
  const std::string& address = side.is_left ? options.left_address : options.right_address;
  const std::string& serial = side.is_left ? options.left_serial : options.right_serial;
  side.camera = arv_gv_fake_camera_new(address.c_str(), serial.c_str());
  if (side.camera == nullptr || arv_gv_fake_camera_is_running(side.camera) == 0) {
    return Error{
        "cannot serve a camera", address,
        fmt::format("no interface has this address, or its port is taken: `ip address add {}/8 dev lo`", address)};
  }
  ArvFakeCamera* fake = arv_gv_fake_camera_get_fake_camera(side.camera);
  const auto set = [fake](guint32 address_of, double value) {
    arv_fake_camera_write_register(fake, address_of, static_cast<guint32>(std::lround(value)));
  };
  set(ARV_FAKE_CAMERA_REGISTER_SENSOR_WIDTH, width);
  set(ARV_FAKE_CAMERA_REGISTER_SENSOR_HEIGHT, height);
  set(ARV_FAKE_CAMERA_REGISTER_WIDTH, width);
  set(ARV_FAKE_CAMERA_REGISTER_HEIGHT, height);
  set(ARV_FAKE_CAMERA_REGISTER_ACQUISITION_FRAME_PERIOD_US, 1e6 / options.rate_hz);
  arv_fake_camera_set_trigger_frequency(fake, 1000.0);
  arv_fake_camera_set_fill_pattern(
      fake,
      [](ArvBuffer* buffer, void* data, guint32, guint32, ArvPixelFormat) {
        auto* of = static_cast<Side*>(data);
        of->rig->fill(*of, buffer);
      },
      &side);
  return {};
}

HilCameras::HilCameras(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
HilCameras::HilCameras(HilCameras&&) noexcept = default;
HilCameras::~HilCameras() = default;

Result<HilCameras> HilCameras::start(drivers::FrameSource& source, const HilOptions& options) {
  auto impl = std::make_unique<Impl>();
  impl->options = options;
  impl->log.setstate(std::ios::failbit);
  if (!options.log.empty()) {
    impl->log.clear();
    impl->log.open(options.log);
    if (!impl->log) return Error{"cannot write log", options.log, "name a file in a folder of yours"};
  }
  impl->width = source.info().width;
  impl->height = source.info().height;
  std::size_t bytes = 0;
  drivers::StereoPair pair;
  for (;;) {
    const auto more = source.next(pair);
    if (!more) return more.error();
    if (!*more) break;
    impl->pairs.push_back({packed(pair.left), packed(pair.right)});
    bytes += impl->pairs.back().left.size() + impl->pairs.back().right.size();
    if (bytes > kMostBytes) {
      return Error{"recording too large to serve from memory", source.info().description,
                   "serve a part of it: set --first and --last"};
    }
  }
  if (impl->pairs.empty()) return Error{"no pair to serve", source.info().description, "choose other pairs"};
  for (const bool left : {true, false}) {
    Impl::Side& side = impl->sides[left ? 0 : 1];
    side.rig = impl.get();
    side.is_left = left;
  }
  HilCameras out(std::move(impl));
  if (auto ok = out.plug_in(); !ok) return ok.error();
  return out;
}

void HilCameras::unplug() { impl_->unplug(); }

Result<void> HilCameras::plug_in() {
  for (Impl::Side& side : impl_->sides) {
    side.seen = false;
    if (auto ok = impl_->plug_in(side); !ok) return ok;
  }
  return {};
}

HilCounts HilCameras::counts() const {
  const std::lock_guard<std::mutex> lock(impl_->mutex);
  return {impl_->sides[0].sent, impl_->sides[1].sent};
}

std::int64_t HilCameras::pairs() const { return static_cast<std::int64_t>(impl_->pairs.size()); }

}  // namespace cliquevo::tools
