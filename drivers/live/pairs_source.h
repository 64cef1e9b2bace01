// SPDX-License-Identifier: BSD-3-Clause
// A family's cameras (V4l2Pairs, LibcameraPairs: open, width, height, next, interrupt, status) as a source of frames.
#pragma once

#include <memory>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "drivers/live/camera_options.h"

namespace cliquevo::drivers {

template <typename Pairs>
class PairsSource final : public FrameSource {
 public:
  PairsSource(SourceInfo info, std::unique_ptr<Pairs> pairs) : info_(std::move(info)), pairs_(std::move(pairs)) {}
  const SourceInfo& info() const override { return info_; }
  Result<bool> next(StereoPair& pair) override { return pairs_->next(pair); }
  void interrupt() override { pairs_->interrupt(); }
  std::string status() const override { return pairs_->status(); }
  std::string queues() const override { return pairs_->queues(); }

 private:
  SourceInfo info_;
  std::unique_ptr<Pairs> pairs_;
};

// family: its usual name. trouble: set with an error.
template <typename Pairs>
Result<std::unique_ptr<FrameSource>> open_pairs_source(const CameraOptions& options, const char* family,
                                                       OpenTrouble& trouble) {
  trouble = OpenTrouble::lasting;
  if (auto ok = options.check(); !ok) return ok.error();
  if (auto ok = options.check_names(); !ok) return ok.error();
  if (auto ok = check_live_calibration(options); !ok) return ok.error();
  auto pairs = Pairs::open(options, trouble);
  if (!pairs) return pairs.error();
  trouble = OpenTrouble::lasting;
  const std::string name = options.layout == CameraLayout::two_cameras
                               ? fmt::format("{} and {}", options.left, options.right)
                               : options.left;
  auto info =
      live_source_info(options, (*pairs)->width(), (*pairs)->height(), fmt::format("cameras {} ({})", name, family));
  if (!info) return info.error();
  return std::unique_ptr<FrameSource>(std::make_unique<PairsSource<Pairs>>(std::move(*info), std::move(*pairs)));
}

}  // namespace cliquevo::drivers
