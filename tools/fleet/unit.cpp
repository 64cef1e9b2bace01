// SPDX-License-Identifier: BSD-3-Clause
#include "tools/fleet/unit.h"

#include <cerrno>
#include <cstring>
#include <ctime>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "core/base/time.h"
#include "tools/fleet/digest.h"
#include "tools/fleet/unit_key.h"
#include "tools/fleet/unit_result.h"
#include "tools/source_argument.h"

namespace cliquevo::tools::fleet {

namespace {

using nlohmann::json;

// The writer of trajectories wants a file: one in memory.
class MemoryFile {
 public:
  MemoryFile() : descriptor_(::memfd_create("trajectory", MFD_CLOEXEC)) {}
  ~MemoryFile() {
    if (descriptor_ >= 0) ::close(descriptor_);
  }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  std::string path() const { return fmt::format("/proc/self/fd/{}", descriptor_); }
  std::string content() const {
    struct stat status {};
    if (::fstat(descriptor_, &status) != 0) return "";
    std::string out(static_cast<std::size_t>(status.st_size), '\0');
    for (std::size_t got = 0; got < out.size();) {
      const ssize_t more = ::pread(descriptor_, out.data() + got, out.size() - got, static_cast<off_t>(got));
      if (more <= 0) return "";
      got += static_cast<std::size_t>(more);
    }
    return out;
  }

 private:
  int descriptor_;
};

std::optional<RunReference> find_reference(const std::string& source, const RunLog& log,
                                           const drivers::SourceInfo& info) {
  if (is_simulator(source)) return reference_from_truth(log.frames());
  const std::string beside = reference_beside(source);
  if (beside.empty()) return std::nullopt;
  auto reference = reference_from_file(beside, log.frames(), info);
  if (!reference) return std::nullopt;
  return std::move(*reference);
}

double processor_s() {
  rusage used{};
  ::getrusage(RUSAGE_SELF, &used);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  return seconds(used.ru_utime) + seconds(used.ru_stime);
}

std::string cost_text(const RunLog& log, const ReplayEnd& end, double wall_s) {
  char host[256] = {};
  ::gethostname(host, sizeof host - 1);
  const json out = {{"host", host},
                    {"frames", log.frames().size()},
                    {"replay_s", end.wall_s},
                    {"wall_s", wall_s},
                    {"processor_s", processor_s()},
                    {"ended_unix_s", static_cast<std::int64_t>(std::time(nullptr))},
                    {"time_ms", times_json(log)}};
  return out.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
}

Error changed(const Recording& recording) {
  return {"not what was planned: the recording, its calibration or the program has changed", recording.source,
          "plan again (cliquevo fleet plan)"};
}

// Whether all of it was there to its end: one that vanished meanwhile is skipped pair by pair, which is no result.
Result<void> judge(const Recording& recording, const daemon::Config& config, const drivers::SourceInfo& info,
                   const SourceIdentity& before, const RunLog& log) {
  if (!log.skipped().empty()) {
    const auto after = identify(recording.source, config, info);
    if (!after) return after.error();
    if (after->digest != before.digest) return changed(recording);
  }
  if (!log.frames().empty()) return {};
  if (log.skipped().empty())
    return Error{"no pair to play", recording.source, "choose other pairs (first, last, every)"};
  const Error& first = log.skipped().entries().front().error;
  return Error{"no pair could be played", recording.source, "see the first: " + first.line()};
}

}  // namespace

Result<UnitTexts> compute_unit(const Plan& plan, const Unit& unit, const UnitWatcher& watcher) {
  const std::int64_t begin_ns = monotonic_ns();
  const Recording& recording = plan.recording_of(unit);
  const auto config = daemon::parse_config(plan.configuration_of(unit).yaml, plan.configuration_of(unit).name);
  if (!config) return config.error();
  const auto source = open_unit_source(recording.source, *config);
  if (!source) return source.error();
  const drivers::SourceInfo& info = (*source)->info();
  const auto identity = identify(recording.source, *config, info);
  if (!identity) return identity.error();
  const std::string& build = watcher.any_build ? plan.build : build_digest();
  if (unit_key(build, *config, *identity, plan.trajectories) != unit.key) return changed(recording);
  auto pipeline = daemon::FramePipeline::make({config->stereo, config->odometry, config->rectify}, info);
  if (!pipeline) return pipeline.error();

  const MemoryFile poses;
  ReplayOutputs outputs;
  auto writer = daemon::TrajectoryWriter::open(poses.path(), daemon::TrajectoryFormat::kitti);
  if (!writer) return writer.error();
  outputs.trajectory = std::move(*writer);
  if (watcher.make_report) outputs.report = watcher.make_report();
  RunLog log;
  const ReplayEnd end = run_replay(**source, *pipeline, outputs, log);
  if (end.error) return *end.error;
  log.set_finding((*source)->finding());
  if (auto good = judge(recording, *config, info, *identity, log); !good) return good.error();

  UnitTexts out;
  out.trajectory = poses.content();
  const auto reference = find_reference(recording.source, log, info);
  const json result = result_json(log, pipeline->model(), reference, sha256(out.trajectory));
  out.result = result.dump(-1, ' ', false, json::error_handler_t::replace) + "\n";
  if (watcher.finish) {
    const UnitRun run{*config, info, pipeline->model(), log, end, outputs, reference, out.result};
    if (auto done = watcher.finish(run); !done) return done.error();
  }
  out.cost = cost_text(log, end, static_cast<double>(monotonic_ns() - begin_ns) * 1e-9);
  return out;
}

Result<RunFigures> figures_of_result(const std::string& result, const std::string& cost, const std::string& where) {
  const json in = json::parse(result, nullptr, false);
  const json spent = json::parse(cost, nullptr, false);
  const auto number = [](const json& object, const char* key) -> std::optional<double> {
    const auto found = object.is_object() ? object.find(key) : object.end();
    if (!object.is_object() || found == object.end() || !found->is_number()) return std::nullopt;
    return found->get<double>();
  };
  if (!number(in, "frames") || !number(in, "failed")) {
    return Error{"no result of a unit", where, "remove it: it is computed again"};
  }
  RunFigures out;
  out.frames = *number(in, "frames");
  out.failed = *number(in, "failed");
  out.skipped = number(in, "skipped").value_or(0.0);
  out.quality = number(in, "quality");
  out.inliers = number(in, "inliers");
  if (const auto reference = in.find("reference"); reference != in.end()) {
    out.segments_pct = number(*reference, "segments_pct");
    out.rotation_deg_m = number(*reference, "rotation_deg_m");
    out.end_pct = number(*reference, "end_pct");
    out.ate_m = number(*reference, "ate_m");
  }
  if (const auto times = spent.is_object() ? spent.find("time_ms") : spent.end();
      spent.is_object() && times != spent.end()) {
    out.time_ms = number(*times, "median");
    out.time_p95_ms = number(*times, "p95");
  }
  return out;
}

}  // namespace cliquevo::tools::fleet
