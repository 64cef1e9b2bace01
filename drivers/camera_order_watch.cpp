// SPDX-License-Identifier: BSD-3-Clause
#include "drivers/camera_order_watch.h"

#include <atomic>
#include <optional>
#include <utility>

#include "stereo/camera_order.h"
#include "stereo/rectify.h"

namespace cliquevo::drivers {

namespace {

// The order of the cameras by rectified images; nothing where the calibration allows none.
class RectifiedOrder {
 public:
  static std::optional<RectifiedOrder> make(const SourceInfo& info) {
    auto rectifier = stereo::Rectifier::make(info.calibration);
    if (!rectifier) return std::nullopt;
    auto check = stereo::CameraOrderCheck::make(rectifier->model().width, rectifier->model().height);
    if (!check) return std::nullopt;
    return RectifiedOrder(std::move(*rectifier), std::move(*check));
  }

  bool wants(std::int64_t number) const { return check_.wants(number); }
  // Each order with the rectification that belongs to it: exchanged images fit that of the other camera.
  stereo::CameraOrder look(const StereoPair& pair) {
    stereo::OrderEvidence seen;
    seen.forward = matched(pair.left, pair.right);
    seen.backward = matched(pair.right, pair.left);
    seen.identical = stereo::are_identical(pair.left.cview(), pair.right.cview());
    check_.add(seen);
    return check_.order();
  }

 private:
  double matched(const Image<std::uint8_t>& left, const Image<std::uint8_t>& right) {
    using stereo::CameraSide;
    const bool rectified = rectifier_.rectify(CameraSide::left, left.cview(), left_.view()).ok() &&
                           rectifier_.rectify(CameraSide::right, right.cview(), right_.view()).ok();
    return rectified ? check_.measure_forward(left_.cview(), right_.cview()) : 0.0;
  }

  RectifiedOrder(stereo::Rectifier rectifier, stereo::CameraOrderCheck check)
      : rectifier_(std::move(rectifier)), check_(std::move(check)) {
    left_.resize(rectifier_.model().width, rectifier_.model().height);
    right_.resize(rectifier_.model().width, rectifier_.model().height);
  }

  stereo::Rectifier rectifier_;
  stereo::CameraOrderCheck check_;
  Image<std::uint8_t> left_;
  Image<std::uint8_t> right_;
};

class CameraOrderWatch final : public FrameSource {
 public:
  CameraOrderWatch(std::unique_ptr<FrameSource> source, bool swap)
      : source_(std::move(source)), swap_(swap), order_(RectifiedOrder::make(source_->info())) {
    if (swap_) swapped_info_ = swapped(source_->info());
  }

  const SourceInfo& info() const override { return swapped_info_ ? *swapped_info_ : source_->info(); }
  Result<bool> next(StereoPair& pair) override {
    auto more = source_->next(pair);
    if (!more || !*more) return more;
    if (swap_) exchange(pair);
    if (order_ && order_->wants(count_)) found_.store(order_->look(pair), std::memory_order_relaxed);
    ++count_;
    return more;
  }
  void interrupt() override { source_->interrupt(); }
  std::string status() const override {
    const std::string own = finding();
    std::string out = source_->status();
    if (own.empty()) return out;
    return out.empty() ? own : out + "; " + own;
  }
  std::string finding() const override {
    std::string out = source_->finding();
    const std::string own = stereo::describe(found_.load(std::memory_order_relaxed));
    if (own.empty()) return out;
    return out.empty() ? own : out + "; " + own;
  }
  std::string queues() const override { return source_->queues(); }

 private:
  static SourceInfo swapped(const SourceInfo& info) {
    SourceInfo out;
    out.description = info.description + " (cameras swapped)";
    out.width = info.width;
    out.height = info.height;
    out.frame_count = info.frame_count;
    out.rate_hz = info.rate_hz;
    out.first_number = info.first_number;
    out.live = info.live;
    out.calibration = info.calibration;
    if (!info.left_mask.empty()) out.right_mask.copy_from(info.left_mask.cview());
    if (!info.right_mask.empty()) out.left_mask.copy_from(info.right_mask.cview());
    return out;
  }
  static void exchange(StereoPair& pair) {
    std::swap(pair.left, pair.right);
    pair.stamp_ns += pair.right_offset_ns;
    pair.right_offset_ns = -pair.right_offset_ns;
  }

  std::unique_ptr<FrameSource> source_;
  bool swap_;
  std::optional<RectifiedOrder> order_;
  std::optional<SourceInfo> swapped_info_;
  std::int64_t count_ = 0;
  std::atomic<stereo::CameraOrder> found_{stereo::CameraOrder::unknown};
};

}  // namespace

std::unique_ptr<FrameSource> watch_camera_order(std::unique_ptr<FrameSource> source, bool swap) {
  return std::make_unique<CameraOrderWatch>(std::move(source), swap);
}

}  // namespace cliquevo::drivers
