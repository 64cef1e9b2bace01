// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include <fmt/format.h>

#include "drivers/libcamera.h"
#include "drivers/libcamera/libcamera_pairs.h"

namespace cliquevo::drivers {

namespace {

class LibcameraSource final : public FrameSource {
 public:
  LibcameraSource(SourceInfo info, std::unique_ptr<LibcameraPairs> pairs)
      : info_(std::move(info)), pairs_(std::move(pairs)) {}
  const SourceInfo& info() const override { return info_; }
  Result<bool> next(StereoPair& pair) override { return pairs_->next(pair); }
  void interrupt() override { pairs_->interrupt(); }
  std::string status() const override { return pairs_->status(); }

 private:
  SourceInfo info_;
  std::unique_ptr<LibcameraPairs> pairs_;
};

}  // namespace

Result<std::unique_ptr<FrameSource>> open_libcamera(const CameraOptions& options) {
  if (auto ok = options.check(); !ok) return ok.error();
  if (auto ok = options.check_names(); !ok) return ok.error();
  auto pairs = LibcameraPairs::open(options);
  if (!pairs) return pairs.error();
  const std::string name =
      options.layout == EyeLayout::two_cameras ? fmt::format("{} and {}", options.left, options.right) : options.left;
  auto info =
      live_source_info(options, (*pairs)->width(), (*pairs)->height(), fmt::format("cameras {} (libcamera)", name));
  if (!info) return info.error();
  return std::unique_ptr<FrameSource>(std::make_unique<LibcameraSource>(std::move(*info), std::move(*pairs)));
}

}  // namespace cliquevo::drivers
