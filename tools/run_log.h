// SPDX-License-Identifier: BSD-3-Clause
// What a replay records of each frame, and its summary of the run at the end.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/vo/visual_odometry.h"
#include "daemon/pipeline/frame_pipeline.h"
#include "drivers/frame_source.h"
#include "tools/evaluation.h"
#include "tools/skipped_pairs.h"

namespace cliquevo::tools {

struct FrameRecord {
  std::int64_t index = 0;
  vo::Estimate estimate;
  std::int64_t read_ns = 0;  // waiting for the pair
  daemon::StageTimes times;
  std::optional<RigidTransform> truth_T_world_camera;

  std::int64_t total_ns() const { return times.rectify_ns + times.stereo_ns + times.odometry_ns; }
};

// The run's reference, matched to its frames.
struct RunReference {
  std::string name;  // file, or "the simulator's truth"
  std::vector<PosePair> pairs;
  bool align = false;  // only positions are comparable, after a rigid alignment
};

class RunLog {
 public:
  void add(const FrameRecord& record);
  // A pair that the source could not deliver.
  void skip(std::int64_t index, const Error& why) { skipped_.add(index, why); }
  // What the images show to be wrong with the source: the self-check's result then means nothing.
  void set_finding(std::string finding) { finding_ = std::move(finding); }

  const std::vector<FrameRecord>& frames() const { return frames_; }
  std::vector<std::size_t> failed() const;  // positions in frames(); the first frame cannot fail
  const SkippedPairs& skipped() const { return skipped_; }
  double distance_m() const { return distance_m_; }

  // The text printed at the end: verdicts, stage times, errors against the reference where there is one.
  std::string summary(double wall_s, const std::optional<RunReference>& reference) const;
  // The file of --stats.
  std::string stats_json(const drivers::SourceInfo& source, const StereoModel& model, double wall_s,
                         const std::optional<RunReference>& reference) const;

 private:
  std::vector<FrameRecord> frames_;
  SkippedPairs skipped_;
  std::string finding_;
  double distance_m_ = 0.0;
};

struct Spread {
  double median = 0.0;
  double p95 = 0.0;
  double max = 0.0;
};
// Of any order of values; zeros when there are none.
Spread spread_of(std::vector<double> values);

}  // namespace cliquevo::tools
