// SPDX-License-Identifier: BSD-3-Clause
// Health of the daemon: once a second a message and a line for systemd; at any time, whether its watchdog may be fed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include <cliquevo/health_t.hpp>

#include "core/rt/histogram.h"
#include "daemon/diagnostics.h"
#include "daemon/threads/pipeline.h"

namespace cliquevo::daemon {

class Health {
 public:
  // A stage that has had work for longer without finishing any stands still.
  static constexpr std::int64_t kStillNs = 1'000'000'000;

  Health(const Pipeline& pipeline, const SentCounts& sent, const LatestDiagnostics& diagnostics,
         const std::string& source_description);

  // Fed by progress, not by time: false while a stage with work stands still. A source that sends nothing is no reason:
  // it is waited for, and reported.
  bool may_feed_watchdog() const;
  // Frames have gone out, or it is clear that the source sends none.
  bool ready() const;
  // About once a second. recording: a line on what is recorded; empty = nothing is. incidents: see Incidents::text().
  const health_t& update(std::int64_t now_mono_ns, const std::string& recording = "",
                         const std::string& incidents = "");
  // One line: state, rate, latency, drops. Of the last update().
  const std::string& status_text() const { return status_text_; }

 private:
  void judge(std::int64_t grabbed_now, std::int64_t sent_now);
  void fill_latencies(health_t& out);
  void fill_diagnostics(health_t& out) const;

  const Pipeline& pipeline_;
  const SentCounts& sent_;
  const LatestDiagnostics& diagnostics_;
  std::string source_;
  std::int64_t start_ns_;
  std::int64_t last_update_ns_;
  std::int64_t last_frame_ns_;  // when a frame was last seen to have come
  PipelineCounts last_counts_;
  std::int64_t last_valid_ = 0;
  std::vector<rt::Histogram::Counts> last_histograms_;
  health_t message_{};
  std::string status_text_ = "starting";
};

}  // namespace cliquevo::daemon
