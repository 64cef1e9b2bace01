// SPDX-License-Identifier: BSD-3-Clause
// How the daemon comes by its pairs: opens the source, which may have to be waited for, and makes what works on them.
// Slow steps run on a thread of their own; meanwhile the watchdog is fed, signals are taken, and what is waited for is
// reported: in the service's status, in VO_HEALTH, and in the log once whenever it changes.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include <cliquevo/health_t.hpp>

#include "daemon/lcm/publisher.h"
#include "daemon/pipeline/config.h"
#include "daemon/pipeline/rectified_size.h"
#include "daemon/pipeline/stages.h"
#include "daemon/service.h"
#include "daemon/signals.h"
#include "drivers/frame_source.h"

namespace cliquevo::daemon {

struct Rig {
  std::unique_ptr<drivers::FrameSource> source;
  RectifiedSize size;
  StereoStage stereo;
  OdometryStage odometry;
};

// One try. trouble: set with an error.
Result<std::unique_ptr<Rig>> open_rig(const Config& config, drivers::OpenTrouble& trouble);

// VO_HEALTH while a camera is waited for.
health_t waiting_health(std::int64_t start_mono_ns, const std::string& waiting_for);

class StartUp {
 public:
  StartUp(const Config& config, const Signals& signals, Service& service);

  // One try. An error: waiting does not help. Null: a camera is not there, or a stop was requested meanwhile.
  Result<std::unique_ptr<Rig>> try_once();
  // Tries until it is there. Null: a stop was requested.
  Result<std::unique_ptr<Rig>> wait(Publisher& publisher);
  bool stop_asked() const { return stop_asked_; }
  // A SIGHUP came meanwhile; the reload is to be done once frames flow.
  bool reload_asked() const { return reload_asked_; }

 private:
  bool tick(std::int64_t pause_ns);
  void report(const Error& error);

  const Config& config_;
  const Signals& signals_;
  Service& service_;
  Publisher* publisher_ = nullptr;
  std::int64_t start_ns_;
  std::int64_t next_health_ns_ = 0;
  std::string waiting_for_;  // empty = it does not wait
  std::string logged_;       // the last state that was logged
  bool stop_asked_ = false;
  bool reload_asked_ = false;
};

}  // namespace cliquevo::daemon
