// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/v4l2/v4l2_pairs.h"

#include <algorithm>
#include <chrono>
#include <linux/videodev2.h>
#include <utility>

#include <fmt/format.h>

#include "core/base/caught.h"

namespace cliquevo::drivers {

namespace {

using std::chrono::milliseconds;

constexpr milliseconds kFirstRetry{200};
constexpr milliseconds kLastRetry{2000};
constexpr int kTakeMs = 100;
constexpr std::int64_t kSilentNs = 3'000'000'000;  // a stream that has stopped without a word is opened again
constexpr std::int64_t kFollowNs = 500'000'000;
constexpr std::int64_t kControlNs = 250'000'000;  // how often an exposure control of our own acts

}  // namespace

Result<std::unique_ptr<V4l2Pairs>> V4l2Pairs::open(const CameraOptions& options, OpenTrouble& trouble) {
  std::vector<V4l2Camera> cameras;
  auto left = V4l2Camera::open(options.left, options, false, trouble);
  if (!left) return left.error();
  cameras.push_back(std::move(*left));
  if (options.layout == CameraLayout::two_cameras) {
    auto right = V4l2Camera::open(options.right, options, true, trouble);
    if (!right) return right.error();
    cameras.push_back(std::move(*right));
    const V4l2Camera& l = cameras[0];
    const V4l2Camera& r = cameras[1];
    if (l.width() != r.width() || l.height() != r.height()) {
      return Error{
          "cameras have unequal sizes", fmt::format("{} and {}", options.left, options.right),
          fmt::format("they give {}x{} and {}x{}: set width and height", l.width(), l.height(), r.width(), r.height())};
    }
  }
  PairSyncOptions sync;
  sync.rate_hz = options.rate_hz;
  sync.triggered = options.trigger != CameraTrigger::off;
  sync.shared_clock = true;  // the kernel's
  sync.stamped_on_arrival = true;
  const int width = image_width(options.layout, cameras[0].fourcc(), cameras[0].width());
  const int height = cameras[0].height();
  return std::unique_ptr<V4l2Pairs>(new V4l2Pairs(options, sync, std::move(cameras), width, height));
}

V4l2Pairs::V4l2Pairs(const CameraOptions& options, const PairSyncOptions& sync, std::vector<V4l2Camera> cameras,
                     int width, int height)
    : options_(options), width_(width), height_(height), pairs_(sync, width, height) {
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    threads_.emplace_back(
        [this, side = i == 0 ? CameraSide::left : CameraSide::right, camera = std::move(cameras[i])]() mutable {
          keep_going(
              "camera's thread", stop_, [&] { run(side, std::move(camera)); },
              [&](const Error& error) { pairs_.set_state(side, error.line()); });
        });
  }
}

V4l2Pairs::~V4l2Pairs() {
  interrupt();
  for (std::thread& thread : threads_) thread.join();
}

void V4l2Pairs::interrupt() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  pairs_.interrupt();
}

void V4l2Pairs::run(CameraSide side, V4l2Camera first) {
  {
    V4l2Camera camera(std::move(first));
    stream(side, camera);
  }
  milliseconds pause = kFirstRetry;
  while (!stop_) {
    pairs_.set_state(side, "reconnecting");
    OpenTrouble ignored = OpenTrouble::lasting;  // whatever it is, there is nothing else to do than to try again
    auto opened = V4l2Camera::open(side == CameraSide::left ? options_.left : options_.right, options_,
                                   side == CameraSide::right, ignored);
    const bool fits = opened.ok() && opened->height() == height_ &&
                      image_width(options_.layout, opened->fourcc(), opened->width()) == width_;
    if (fits && stream(side, *opened)) pause = kFirstRetry;
    if (!opened.ok()) pairs_.set_state(side, "reconnecting: " + opened.error().what);
    if (opened.ok() && !fits) pairs_.set_state(side, "reconnecting: it is back with another size");
    std::unique_lock<std::mutex> lock(mutex_);
    changed_.wait_for(lock, pause, [this] { return stop_.load(); });
    pause = std::min(2 * pause, kLastRetry);
  }
}

// Until it is lost or all is over. false: it delivered nothing.
bool V4l2Pairs::stream(CameraSide side, V4l2Camera& camera) {
  if (!camera.start().ok()) return false;
  pairs_.set_state(side, "");
  bool delivered = false;
  std::int64_t last_ns = monotonic_ns();
  std::int64_t next_follow_ns = 0;
  std::int64_t next_control_ns = 0;
  const std::int64_t patience_ns = std::max(kSilentNs, static_cast<std::int64_t>(5e9 / options_.rate_hz));
  V4l2Frame frame;
  while (!stop_) {
    const V4l2Taken taken = camera.take(kTakeMs, frame);
    const std::int64_t now_ns = monotonic_ns();
    if (taken == V4l2Taken::lost || now_ns - last_ns > patience_ns) {
      pairs_.set_state(side, taken == V4l2Taken::lost ? "lost" : "silent");
      return delivered;
    }
    if (taken == V4l2Taken::incomplete) pairs_.count_incomplete(side);
    if (taken == V4l2Taken::frame) {
      const bool whole = hand_on(side, frame);
      delivered = true;
      if (whole && camera.controls_exposure() && now_ns >= next_control_ns) {
        next_control_ns = now_ns + kControlNs;
        camera.control_exposure(grey_[static_cast<std::size_t>(side)].left.cview());
      }
    }
    if (taken != V4l2Taken::nothing) last_ns = now_ns;
    if (now_ns >= next_follow_ns) {
      next_follow_ns = now_ns + kFollowNs;
      share_exposure(side, camera);
    }
  }
  return delivered;
}

// false: the frame is not whole.
bool V4l2Pairs::hand_on(CameraSide side, const V4l2Frame& frame) {
  Grey& grey = grey_[static_cast<std::size_t>(side)];
  const Conversion converted = to_grey(frame.raw, options_.layout, grey.left, grey.right);
  if (!converted.whole) {
    pairs_.count_incomplete(side);
    return false;
  }
  if (converted.flawed) pairs_.count_flawed(side);
  const LiveFrame left{grey.left.cview(), frame.stamp_utc_ns, frame.arrival_mono_ns, frame.arrival_utc_ns,
                       frame.sequence};
  if (options_.layout == CameraLayout::two_cameras) {
    pairs_.push(side, left);
    return true;
  }
  LiveFrame right = left;
  right.image = grey.right.cview();
  pairs_.push_pair(left, right);
  return true;
}

// One exposure and gain for both cameras: the right one takes over what the left one's control has found.
void V4l2Pairs::share_exposure(CameraSide side, const V4l2Camera& camera) {
  if (options_.layout != CameraLayout::two_cameras) return;
  if (side == CameraSide::left) {
    if (!options_.exposure_us) exposure_ = camera.control(V4L2_CID_EXPOSURE_ABSOLUTE).value_or(0);
    if (!options_.gain) gain_ = camera.control(V4L2_CID_GAIN).value_or(-1);
    return;
  }
  if (!options_.exposure_us && exposure_ > 0) camera.set_control(V4L2_CID_EXPOSURE_ABSOLUTE, exposure_);
  if (!options_.gain && gain_ >= 0) camera.set_control(V4L2_CID_GAIN, gain_);
}

}  // namespace cliquevo::drivers
