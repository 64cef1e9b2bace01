// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/lcm/status_report.h"

#include <nlohmann/json.hpp>

namespace cliquevo::daemon {

namespace {

const char* name_of_state(std::int8_t state) {
  switch (state) {
    case health_t::RUNNING:
      return "running";
    case health_t::WAITING_FOR_FRAMES:
      return "waiting";
    case health_t::STALLED:
      return "stalled";
    default:
      return "starting";
  }
}

}  // namespace

std::string status_json(const health_t& h, const std::string& version) {
  nlohmann::ordered_json out;
  out["version"] = version;
  out["state"] = name_of_state(h.state);
  out["state_text"] = h.state_text;
  out["utime"] = h.utime;
  out["uptime_s"] = h.uptime_s;
  out["grab_rate_hz"] = h.grab_rate_hz;
  out["pose_rate_hz"] = h.pose_rate_hz;
  out["valid_share"] = h.valid_share;
  out["frames_grabbed"] = h.frames_grabbed;
  out["poses_sent"] = h.poses_sent;
  out["frames_dropped"] = h.frames_dropped;
  out["frames_rejected"] = h.frames_rejected;
  out["source_errors"] = h.source_errors;
  out["send_errors"] = h.send_errors;
  out["resets"] = h.resets;
  out["latency_p50_us"] = h.latency_p50_us;
  out["latency_p99_us"] = h.latency_p99_us;
  out["latency_max_us"] = h.latency_max_us;
  out["resident_bytes"] = h.resident_bytes;
  out["source_text"] = h.source_text;
  out["recording_text"] = h.recording_text;
  out["incident_text"] = h.incident_text;
  out["calibration_text"] = h.calibration_text;
  out["view_text"] = h.view_text;
  // Texts may hold what a camera or a file calls itself.
  return out.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace cliquevo::daemon
