// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/pipeline/frame_pipeline.h"

#include <utility>

#include "daemon/pipeline/stages.h"

namespace cliquevo::daemon {

struct FramePipeline::Impl {
  StereoStage stereo;
  OdometryStage odometry;
  StereoFrame frame;
};

FramePipeline::FramePipeline(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
FramePipeline::FramePipeline(FramePipeline&&) noexcept = default;
FramePipeline& FramePipeline::operator=(FramePipeline&&) noexcept = default;
FramePipeline::~FramePipeline() = default;

Result<FramePipeline> FramePipeline::make(const PipelineParams& params, const drivers::SourceInfo& source) {
  auto stereo = StereoStage::make(params.stereo, source, params.rectify);
  if (!stereo) return stereo.error();
  auto odometry = OdometryStage::make(params.odometry, source, *stereo);
  if (!odometry) return odometry.error();
  auto impl = std::make_unique<Impl>(Impl{std::move(*stereo), std::move(*odometry), {}});
  impl->stereo.prepare(impl->frame);
  return FramePipeline(std::move(impl));
}

Result<void> FramePipeline::process(const drivers::StereoPair& pair) {
  if (auto ok = impl_->stereo.run(pair, impl_->frame); !ok) return ok;
  return impl_->odometry.run(pair.stamp_ns, impl_->frame);
}

const vo::Estimate& FramePipeline::estimate() const { return impl_->odometry.estimate(); }
const vo::Movers& FramePipeline::movers() const { return impl_->odometry.movers(); }
void FramePipeline::list_features(std::vector<vo::SeenFeature>& out) const { impl_->odometry.list_features(out); }
const StageTimes& FramePipeline::times() const { return impl_->frame.times; }
const StereoModel& FramePipeline::model() const { return impl_->stereo.model(); }
ImageView<const std::uint8_t> FramePipeline::rectified_left() const { return impl_->frame.left.cview(); }
ImageView<const std::uint8_t> FramePipeline::rectified_right() const { return impl_->frame.right.cview(); }
ImageView<const std::int16_t> FramePipeline::disparity() const { return impl_->frame.disparity.cview(); }
ImageView<const std::uint8_t> FramePipeline::mask() const { return impl_->odometry.mask(); }

}  // namespace cliquevo::daemon
