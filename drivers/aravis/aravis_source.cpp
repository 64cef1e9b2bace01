// SPDX-License-Identifier: BSD-3-Clause
// A pair of cameras: one thread per camera that keeps it streaming, whatever happens, and one that triggers.
#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <ctime>
#include <mutex>
#include <netinet/in.h>
#include <sys/socket.h>
#include <thread>
#include <unistd.h>
#include <utility>

#include <fmt/format.h>

#include "core/base/caught.h"
#include "core/base/clock.h"
#include "drivers/aravis.h"
#include "drivers/aravis/aravis_camera.h"
#include "drivers/live/live_pairs.h"

namespace cliquevo::drivers {

namespace {

using std::chrono::milliseconds;
using std::chrono::steady_clock;

constexpr milliseconds kFirstRetry{200};
constexpr milliseconds kLastRetry{2000};
constexpr std::uint64_t kTakeUs = 100'000;
constexpr std::int64_t kFollowNs = 500'000'000;   // how often the right camera takes over the left one's exposure
constexpr std::int64_t kControlNs = 250'000'000;  // how often a control of our own acts
constexpr double kMostSkewS = 0.005;
constexpr std::uint16_t kGvcpPort = 3956;

// Both cameras have one exposure and gain: what the leader's control found, for the follower.
struct SharedExposure {
  std::atomic<double> exposure_us{0.0};
  std::atomic<double> gain{-1.0};
};

class AravisPair final : public FrameSource {
 public:
  AravisPair(const CameraOptions& options, SourceInfo info, const PairSyncOptions& sync, AravisCamera left,
             AravisCamera right)
      : options_(options), info_(std::move(info)), pairs_(sync, info_.width, info_.height) {
    cameras_[0].emplace(std::move(left));
    cameras_[1].emplace(std::move(right));
    for (const CameraSide side : {CameraSide::left, CameraSide::right}) {
      threads_.emplace_back([this, side] {
        keep_going(
            "camera's thread", stop_, [&] { run(side); },
            [&](const Error& error) { pairs_.set_state(side, error.line()); });
      });
    }
    if (options_.trigger == CameraTrigger::software || options_.trigger == CameraTrigger::action) {
      threads_.emplace_back([this] {
        keep_going(
            "trigger", stop_, [&] { trigger(); }, [](const Error&) {});
      });
    }
  }
  ~AravisPair() override {
    interrupt();
    for (std::thread& thread : threads_) thread.join();
  }
  AravisPair(const AravisPair&) = delete;
  AravisPair& operator=(const AravisPair&) = delete;

  const SourceInfo& info() const override { return info_; }
  Result<bool> next(StereoPair& pair) override { return pairs_.next(pair); }
  void interrupt() override {
    {
      const std::lock_guard<std::mutex> lock(mutex_);
      stop_ = true;
    }
    changed_.notify_all();
    pairs_.interrupt();
  }
  std::string status() const override { return pairs_.status(); }
  std::string queues() const override { return pairs_.queues(); }

 private:
  void run(CameraSide side) {
    hurry_this_thread();
    const auto i = static_cast<std::size_t>(side);
    if (cameras_[i]) stream(side, *cameras_[i]);
    close(i);
    milliseconds pause = kFirstRetry;
    while (!stop_) {
      pairs_.set_state(side, "reconnecting");
      OpenTrouble ignored = OpenTrouble::lasting;  // whatever it is, there is nothing else to do than to try again
      auto opened =
          AravisCamera::open(i == 0 ? options_.left : options_.right, options_, side == CameraSide::right, ignored);
      if (opened.ok() && opened->width() == info_.width && opened->height() == info_.height) {
        {
          const std::lock_guard<std::mutex> lock(camera_mutex_[i]);
          cameras_[i].emplace(std::move(*opened));
        }
        if (stream(side, *cameras_[i])) pause = kFirstRetry;
        close(i);
        continue;
      }
      pairs_.set_state(
          side, opened.ok() ? "reconnecting: it is back with another size" : "reconnecting: " + opened.error().what);
      std::unique_lock<std::mutex> lock(mutex_);
      changed_.wait_for(lock, pause, [this] { return stop_.load(); });
      pause = std::min(2 * pause, kLastRetry);
    }
  }

  void close(std::size_t i) {
    const std::lock_guard<std::mutex> lock(camera_mutex_[i]);
    cameras_[i].reset();
  }

  // Until it is lost or all is over. false: it delivered nothing.
  bool stream(CameraSide side, AravisCamera& camera) {
    if (auto ok = camera.start(); !ok) return false;
    pairs_.set_state(side, "");
    bool delivered = false;
    std::int64_t next_follow_ns = 0;
    std::int64_t next_control_ns = 0;
    if (side == CameraSide::right) {  // a camera that comes back has forgotten
      followed_exposure_us_ = 0.0;
      followed_gain_ = -1.0;
    }
    while (!stop_ && !camera.lost()) {
      if (const auto frame = camera.take(kTakeUs)) {
        const std::int64_t now_ns = monotonic_ns();
        if (frame->whole) {
          pairs_.push(side, {frame->image, frame->stamp_ns, now_ns, utc_now_ns()});
          delivered = true;
          if (camera.controls_exposure() && now_ns >= next_control_ns) {
            next_control_ns = now_ns + kControlNs;
            camera.control_exposure(frame->image);
          }
        } else {
          pairs_.count_incomplete(side);
        }
        camera.give_back(*frame);
      }
      if (monotonic_ns() >= next_follow_ns) {
        next_follow_ns = monotonic_ns() + kFollowNs;
        share_exposure(side, camera);
      }
    }
    if (camera.lost()) pairs_.set_state(side, "lost");
    return delivered;
  }

  void share_exposure(CameraSide side, AravisCamera& camera) {
    if (options_.exposure_us && options_.gain) return;
    if (side == CameraSide::left) {
      if (!options_.exposure_us) shared_.exposure_us = camera.exposure_us().value_or(0.0);
      if (!options_.gain) shared_.gain = camera.gain().value_or(-1.0);
      return;
    }
    const double exposure_us = shared_.exposure_us;
    if (exposure_us > 0.0 && exposure_us != followed_exposure_us_) camera.set_exposure_us(exposure_us);
    const double gain = shared_.gain;
    if (gain >= 0.0 && gain != followed_gain_) camera.set_gain(gain);
    followed_exposure_us_ = exposure_us;
    followed_gain_ = gain;
  }

  void trigger() {
    const auto period = std::chrono::nanoseconds(std::llround(1e9 / options_.rate_hz));
    auto due = steady_clock::now();
    std::uint16_t request = 1;
    for (;;) {
      due = std::max(due + period, steady_clock::now() - period);
      std::unique_lock<std::mutex> lock(mutex_);
      if (changed_.wait_until(lock, due, [this] { return stop_.load(); })) return;
      lock.unlock();
      if (options_.trigger == CameraTrigger::action) {
        send_action(request++);
        continue;
      }
      for (const std::size_t i : {std::size_t{0}, std::size_t{1}}) {
        const std::lock_guard<std::mutex> camera_lock(camera_mutex_[i]);
        if (cameras_[i]) cameras_[i]->trigger();
      }
    }
  }

  void send_action(std::uint16_t request) {
    if (socket_ < 0) {
      socket_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
      const int on = 1;
      ::setsockopt(socket_, SOL_SOCKET, SO_BROADCAST, &on, sizeof on);
    }
    sockaddr_in to = {};
    to.sin_family = AF_INET;
    to.sin_port = htons(kGvcpPort);
    to.sin_addr.s_addr = htonl(INADDR_BROADCAST);
    const std::vector<std::uint8_t> packet = action_command(request == 0 ? std::uint16_t{1} : request);
    ::sendto(socket_, packet.data(), packet.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to);
  }

  CameraOptions options_;
  SourceInfo info_;
  LivePairs pairs_;
  std::array<std::optional<AravisCamera>, 2> cameras_;  // a camera's thread's; the trigger's under the mutex
  std::array<std::mutex, 2> camera_mutex_;
  SharedExposure shared_;
  double followed_exposure_us_ = 0.0;  // the right camera's thread's
  double followed_gain_ = -1.0;
  int socket_ = -1;  // the trigger's
  std::mutex mutex_;
  std::condition_variable changed_;
  std::atomic<bool> stop_{false};
  std::vector<std::thread> threads_;
};

Result<AravisCamera> open_patiently(const std::string& name, const CameraOptions& options, bool follows,
                                    OpenTrouble& trouble) {
  const auto give_up = steady_clock::now() + std::chrono::duration<double>(options.patience_s);
  for (;;) {
    auto opened = AravisCamera::open(name, options, follows, trouble);
    if (opened.ok() || trouble != OpenTrouble::held || steady_clock::now() >= give_up) return opened;
    std::this_thread::sleep_for(milliseconds(300));
  }
}

}  // namespace

Result<std::unique_ptr<FrameSource>> open_aravis(const CameraOptions& options, OpenTrouble& trouble) {
  trouble = OpenTrouble::lasting;
  if (auto ok = options.check(); !ok) return ok.error();
  if (auto ok = options.check_names(); !ok) return ok.error();
  if (auto ok = check_live_calibration(options); !ok) return ok.error();
  if (options.layout != CameraLayout::two_cameras) {
    return Error{"configuration value out of range", "layout", "Aravis takes two cameras: set layout to two_cameras"};
  }
  PairSyncOptions sync;
  sync.rate_hz = options.rate_hz;
  sync.triggered = options.trigger != CameraTrigger::off;
  sync.shared_clock = options.shared_clock;
  // We trigger both, one right after the other: what a busy network holds up is no pair.
  const bool we_trigger = options.trigger == CameraTrigger::software || options.trigger == CameraTrigger::action;
  if (we_trigger && options.shared_clock) sync.tolerance = std::min(sync.tolerance, kMostSkewS * options.rate_hz);
  auto left = open_patiently(options.left, options, false, trouble);
  if (!left) return left.error();
  auto right = open_patiently(options.right, options, true, trouble);
  if (!right) return right.error();
  if (left->width() != right->width() || left->height() != right->height()) {
    return Error{"cameras have unequal sizes", fmt::format("{} and {}", options.left, options.right),
                 fmt::format("they give {}x{} and {}x{}: set width and height", left->width(), left->height(),
                             right->width(), right->height())};
  }
  auto info = live_source_info(options, left->width(), left->height(),
                               fmt::format("cameras {} and {} (Aravis)", options.left, options.right));
  if (!info) return info.error();
  return std::unique_ptr<FrameSource>(
      std::make_unique<AravisPair>(options, std::move(*info), sync, std::move(*left), std::move(*right)));
}

std::vector<SeenCamera> list_aravis() {
  arv_update_device_list();
  std::vector<SeenCamera> out;
  for (unsigned i = 0; i < arv_get_n_devices(); ++i) {
    const char* serial = arv_get_device_serial_nbr(i);
    const char* id = serial != nullptr && *serial != '\0' ? serial : arv_get_device_address(i);
    out.push_back({"aravis",
                   id,
                   fmt::format("{} {} at {} ({})", arv_get_device_vendor(i), arv_get_device_model(i),
                               arv_get_device_address(i), arv_get_device_protocol(i)),
                   {}});
  }
  return out;
}

}  // namespace cliquevo::drivers
