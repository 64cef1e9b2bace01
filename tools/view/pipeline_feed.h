// SPDX-License-Identifier: BSD-3-Clause
// A recording or the simulator, run through the pipeline here. The only file of the room that knows the pipeline.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "daemon/pipeline/frame_pipeline.h"
#include "drivers/frame_source.h"
#include "tools/view/facts.h"
#include "tools/view/feed.h"

namespace cliquevo::view {

// Facts of frames as they leave the pipeline, one after the other.
class FactsMaker {
 public:
  FrameFacts make(const daemon::FramePipeline& pipeline, const drivers::StereoPair& pair);
  // What became of that frame's features.
  const std::vector<vo::SeenFeature>& features() const { return features_; }

 private:
  WayUncertainty way_;
  std::optional<RigidTransform> T_first_world_;
  std::vector<vo::SeenFeature> features_;
  std::int64_t count_ = 0;
};

// T_body_camera: how the camera sits on the body.
std::unique_ptr<Feed> make_pipeline_feed(std::unique_ptr<drivers::FrameSource> source, daemon::FramePipeline pipeline,
                                         const RigidTransform& T_body_camera);

}  // namespace cliquevo::view
