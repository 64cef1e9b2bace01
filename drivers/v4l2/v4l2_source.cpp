// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include <fmt/format.h>

#include "drivers/v4l2.h"
#include "drivers/v4l2/v4l2_pairs.h"

namespace cliquevo::drivers {

namespace {

class V4l2Source final : public FrameSource {
 public:
  V4l2Source(SourceInfo info, std::unique_ptr<V4l2Pairs> pairs) : info_(std::move(info)), pairs_(std::move(pairs)) {}
  const SourceInfo& info() const override { return info_; }
  Result<bool> next(StereoPair& pair) override { return pairs_->next(pair); }
  void interrupt() override { pairs_->interrupt(); }
  std::string status() const override { return pairs_->status(); }

 private:
  SourceInfo info_;
  std::unique_ptr<V4l2Pairs> pairs_;
};

}  // namespace

Result<std::unique_ptr<FrameSource>> open_v4l2(const CameraOptions& options) {
  if (auto ok = options.check(); !ok) return ok.error();
  if (auto ok = options.check_names(); !ok) return ok.error();
  auto pairs = V4l2Pairs::open(options);
  if (!pairs) return pairs.error();
  const std::string name =
      options.layout == EyeLayout::two_cameras ? fmt::format("{} and {}", options.left, options.right) : options.left;
  auto info = live_source_info(options, (*pairs)->width(), (*pairs)->height(), fmt::format("cameras {} (V4L2)", name));
  if (!info) return info.error();
  return std::unique_ptr<FrameSource>(std::make_unique<V4l2Source>(std::move(*info), std::move(*pairs)));
}

}  // namespace cliquevo::drivers
